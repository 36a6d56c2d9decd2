// Files coming out: a header, then blocks.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include "client/connection.h"

namespace motiondb::client {
namespace {

namespace fs = std::filesystem;

absl::Status BrokenStream(const std::string& clip, const char* what) {
  return absl::DataLossError(fmt::format("export of {}: {}", clip, what));
}

bool SameBytes(const fs::path& a, const fs::path& b) {
  std::ifstream first(a, std::ios::binary), second(b, std::ios::binary);
  using Iterator = std::istreambuf_iterator<char>;
  return std::equal(Iterator(first), Iterator(), Iterator(second), Iterator());
}

// A file that appears under its name when it is complete, and leaves nothing behind otherwise.
class PendingFile {
 public:
  PendingFile() = default;
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  ~PendingFile() {
    if (!stream_.is_open()) return;
    stream_.close();
    std::error_code ignored;
    fs::remove(Partial(), ignored);
  }

  // `name` comes from the server: only a plain file name is accepted.
  absl::Status Open(const fs::path& directory, const std::string& name) {
    const fs::path plain(name);
    if (name.empty() || plain != plain.filename() || plain == "." || plain == "..") {
      return absl::DataLossError(fmt::format("\"{}\" is not the name of a file", name));
    }
    path_ = directory / plain;
    stream_.open(Partial(), std::ios::binary | std::ios::trunc);
    return Check();
  }

  absl::Status Append(const std::string& block) {
    stream_.write(block.data(), static_cast<std::streamsize>(block.size()));
    return Check();
  }

  // Writes out what is left. ALREADY_EXISTS if other bytes lie under the name; the same bytes do no
  // harm, and clips share skeletons.
  absl::Status Complete(bool overwrite) {
    if (!stream_.is_open()) return absl::OkStatus();
    stream_.flush();
    if (const absl::Status status = Check(); !status.ok()) return status;
    std::error_code ignored;
    if (!overwrite && fs::exists(path_, ignored) && !SameBytes(path_, Partial())) {
      return absl::AlreadyExistsError(
          fmt::format("{}: exists already, with other contents", path_.string()));
    }
    return absl::OkStatus();
  }

  absl::Status Commit() {
    if (!stream_.is_open()) return absl::OkStatus();
    std::error_code error;
    fs::rename(Partial(), path_, error);
    if (error) {
      return absl::UnknownError(fmt::format("{}: {}", path_.string(), error.message()));
    }
    stream_.close();
    return absl::OkStatus();
  }

 private:
  fs::path Partial() const { return path_.string() + ".partial"; }
  absl::Status Check() const {
    if (stream_) return absl::OkStatus();
    return absl::UnknownError(fmt::format("{}: cannot be written", path_.string()));
  }

  fs::path path_;
  std::ofstream stream_;
};

}  // namespace

absl::Status Client::Connection::Export(const v1::ExportClipRequest& request,
                                        const ExportSink& sink, const CallOptions& options) const {
  bool begun = false;
  const std::function<absl::Status(const v1::ExportClipResponse&)> on_message =
      [&](const v1::ExportClipResponse& message) -> absl::Status {
    if (message.has_header() == begun) {
      return BrokenStream(request.name(), "expected one header, before the first block");
    }
    begun = true;
    if (message.has_header()) return sink.on_header(message.header());
    if (message.has_file_block()) return sink.on_file_block(message.file_block());
    return sink.on_skeleton_block(message.skeleton_block());
  };
  const absl::Status status =
      ReadStream(*clips, &v1::ClipService::Stub::ExportClip, request, on_message, options);
  if (status.ok() && !begun) return BrokenStream(request.name(), "the stream had no header");
  return status;
}

absl::StatusOr<ExportedClip> Client::ExportClip(const v1::ExportClipRequest& request,
                                                CallOptions options) const {
  ExportedClip clip;
  ExportSink sink;
  sink.on_header = [&](const v1::ExportClipHeader& header) {
    clip.file_name = header.clip().file_name();
    clip.skeleton_file_name = header.skeleton_file_name();
    return absl::OkStatus();
  };
  sink.on_file_block = [&](const std::string& block) {
    clip.file += block;
    return absl::OkStatus();
  };
  sink.on_skeleton_block = [&](const std::string& block) {
    clip.skeleton += block;
    return absl::OkStatus();
  };
  if (const absl::Status status = connection_->Export(request, sink, options); !status.ok()) {
    return status;
  }
  return clip;
}

absl::StatusOr<v1::ExportClipHeader> Client::ExportClipToDirectory(
    const v1::ExportClipRequest& request, const fs::path& directory, bool overwrite,
    CallOptions options) const {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) {
    return absl::UnknownError(fmt::format("{}: {}", directory.string(), error.message()));
  }
  v1::ExportClipHeader header;
  PendingFile file, skeleton;
  ExportSink sink;
  sink.on_header = [&](const v1::ExportClipHeader& received) -> absl::Status {
    header = received;
    const absl::Status opened = file.Open(directory, header.clip().file_name());
    if (!opened.ok() || header.skeleton_file_name().empty()) return opened;
    return skeleton.Open(directory, header.skeleton_file_name());
  };
  sink.on_file_block = [&](const std::string& block) { return file.Append(block); };
  sink.on_skeleton_block = [&](const std::string& block) { return skeleton.Append(block); };
  if (const absl::Status status = connection_->Export(request, sink, options); !status.ok()) {
    return status;
  }
  for (PendingFile* pending : {&file, &skeleton}) {
    if (const absl::Status status = pending->Complete(overwrite); !status.ok()) return status;
  }
  for (PendingFile* pending : {&file, &skeleton}) {
    if (const absl::Status status = pending->Commit(); !status.ok()) return status;
  }
  return header;
}

}  // namespace motiondb::client
