// Files coming out: a header, then blocks.
#include <fmt/format.h>

#include <optional>
#include <utility>

#include "client/connection.h"
#include "client/output_file.h"

namespace motiondb::client {
namespace {

namespace fs = std::filesystem;

absl::Status BrokenStream(const std::string& clip, const char* what) {
  return absl::DataLossError(fmt::format("export of {}: {}", clip, what));
}

// One of the files that come. `file` has none after Open failed, or where the same bytes are there.
struct ExportedFile {
  fs::path path;
  std::optional<OutputFile> file;

  absl::Status Open(const fs::path& directory, const std::string& name) {
    if (const absl::Status plain = CheckFileNameFromServer(name); !plain.ok()) return plain;
    path = directory / name;
    auto created = OutputFile::Create(path);
    if (!created.ok()) return created.status();
    file = *std::move(created);
    return absl::OkStatus();
  }

  // ALREADY_EXISTS if other bytes lie under the name; the same bytes do no harm, and clips share
  // skeletons.
  absl::Status Compare(bool overwrite) {
    if (!file) return absl::OkStatus();
    const auto same = file->IsThereAlready();
    if (!same.ok()) return same.status();
    std::error_code ignored;
    if (*same) {
      file.reset();
    } else if (!overwrite && fs::exists(fs::symlink_status(path, ignored))) {
      return absl::AlreadyExistsError(
          fmt::format("{}: exists already, with other contents", path.string()));
    }
    return absl::OkStatus();
  }
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
  ExportedFile file, skeleton;
  ExportSink sink;
  sink.on_header = [&](const v1::ExportClipHeader& received) -> absl::Status {
    header = received;
    const std::string& name = header.clip().file_name();
    const absl::Status opened = file.Open(directory, name);
    if (!opened.ok() || header.skeleton_file_name().empty()) return opened;
    if (header.skeleton_file_name() == name) {
      return BrokenStream(request.name(), "the clip and its skeleton have the same file name");
    }
    return skeleton.Open(directory, header.skeleton_file_name());
  };
  sink.on_file_block = [&](const std::string& block) { return file.file->Append(block); };
  sink.on_skeleton_block = [&](const std::string& block) {
    return skeleton.file ? skeleton.file->Append(block)
                         : BrokenStream(request.name(), "a block of a skeleton without a name");
  };
  if (const absl::Status status = connection_->Export(request, sink, options); !status.ok()) {
    return status;
  }
  for (ExportedFile* const pending : {&file, &skeleton}) {
    if (const absl::Status status = pending->Compare(overwrite); !status.ok()) return status;
  }
  for (ExportedFile* const pending : {&file, &skeleton}) {
    if (!pending->file) continue;
    if (const absl::Status status = pending->file->Commit(overwrite); !status.ok()) return status;
  }
  return header;
}

}  // namespace motiondb::client
