// Calls that send or receive files: a header, then blocks.

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>

#include "client/connection.h"
#include "client/input_file.h"
#include "client/output_file.h"

namespace motiondb::client {

namespace {

BlockReader BlocksOf(std::string_view bytes) {
  return [bytes](std::string& block) mutable {
    block.assign(bytes.substr(0, kBlockBytes));
    bytes.remove_prefix(block.size());
    return absl::OkStatus();
  };
}

// A BlockReader can be copied, an open file cannot.
absl::StatusOr<std::shared_ptr<InputFile>> OpenShared(const std::filesystem::path& path) {
  auto opened = InputFile::Open(path);
  if (!opened.ok()) return opened.status();
  return std::make_shared<InputFile>(*std::move(opened));
}

BlockReader BlocksOf(std::shared_ptr<InputFile> file) {
  return [file = std::move(file)](std::string& block) { return file->Read(kBlockBytes, block); };
}

// Sends all blocks. If the server ended the stream early, returns OK; Finish returns the reason.
template <typename Set>
absl::Status Send(grpc::ClientWriter<v1::IngestClipRequest>& writer, const BlockReader& next,
                  const Set& set) {
  while (true) {
    v1::IngestClipRequest message;
    std::string* block = set(message);
    if (const absl::Status status = next(*block); !status.ok()) return status;
    if (block->empty() || !writer.Write(message)) return absl::OkStatus();
  }
}

}  // namespace

absl::StatusOr<v1::IngestClipResponse> Client::Connection::Ingest(
    const v1::IngestClipHeader& header, const OpenIngestSource& open,
    const CallOptions& options) const {
  v1::IngestClipResponse response;
  const auto attempt = [&](OutgoingCall& call) -> absl::Status {
    const auto source = open();
    if (!source.ok()) return source.status();
    call.is_repeatable = source->is_repeatable;
    const auto writer = call.endpoint.clips->IngestClip(&call.context, &response);
    v1::IngestClipRequest first;
    *first.mutable_header() = header;
    absl::Status sent;
    if (writer->Write(first)) {
      sent = Send(*writer, source->skeleton,
                  [](auto& message) { return message.mutable_skeleton_block(); });
      if (sent.ok()) {
        sent =
            Send(*writer, source->file, [](auto& message) { return message.mutable_file_block(); });
      }
    }
    // If a file cannot be read completely, cancel, so that the server does not store a part of it.
    if (!sent.ok()) call.context.TryCancel();
    writer->WritesDone();
    const grpc::Status finished = writer->Finish();
    return sent.ok() ? Finish(finished, call) : sent;
  };
  const absl::Status status = Run(Effect::kChange, options, DatabaseIdOf(header.parent()), attempt);
  if (!status.ok()) return status;
  return response;
}

absl::StatusOr<v1::IngestClipResponse> Client::IngestFile(const v1::IngestClipHeader& header,
                                                          const std::filesystem::path& file,
                                                          const std::filesystem::path& skeleton,
                                                          CallOptions options) const {
  v1::IngestClipHeader named = header;
  if (named.file_name().empty()) named.set_file_name(file.filename().string());
  if (named.skeleton_file_name().empty() && !skeleton.empty()) {
    named.set_skeleton_file_name(skeleton.filename().string());
  }
  const auto open = [&]() -> absl::StatusOr<IngestSource> {
    auto opened = OpenShared(file);
    if (!opened.ok()) return opened.status();
    IngestSource source{BlocksOf(*opened), BlocksOf(std::string_view()),
                        (*opened)->size().has_value()};
    if (skeleton.empty()) return source;
    auto opened_skeleton = OpenShared(skeleton);
    if (!opened_skeleton.ok()) return opened_skeleton.status();
    source.skeleton = BlocksOf(*opened_skeleton);
    source.is_repeatable = source.is_repeatable && (*opened_skeleton)->size().has_value();
    return source;
  };
  return connection_->Ingest(named, open, options);
}

absl::StatusOr<v1::IngestClipResponse> Client::IngestBytes(const v1::IngestClipHeader& header,
                                                           std::string_view file,
                                                           std::string_view skeleton,
                                                           CallOptions options) const {
  const auto open = [&]() -> absl::StatusOr<IngestSource> {
    return IngestSource{BlocksOf(file), BlocksOf(skeleton)};
  };
  return connection_->Ingest(header, open, options);
}

// Receiving files.

namespace {

namespace fs = std::filesystem;

absl::Status BrokenStream(const std::string& clip, const char* what) {
  return absl::DataLossError(fmt::format("export of {}: {}", clip, what));
}

// A received file. `file` is empty after Open failed, or if a file with the same contents exists.
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

  // ALREADY_EXISTS: a file with different contents exists, without `overwrite`. The same contents
  // are accepted, because clips share skeletons.
  absl::Status Compare(bool overwrite) {
    if (!file) return absl::OkStatus();
    const auto same = file->HasSameContent();
    if (!same.ok()) return same.status();
    std::error_code ignored;
    if (*same) {
      file.reset();
    } else if (!overwrite && fs::exists(fs::symlink_status(path, ignored))) {
      return absl::AlreadyExistsError(
          fmt::format("{}: already exists, with different contents", path.string()));
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
  const absl::Status status = ReadStream(&Endpoint::clips, &v1::ClipService::Stub::ExportClip,
                                         request, on_message, options);
  if (status.ok() && !begun) return BrokenStream(request.name(), "the stream had no header");
  return status;
}

namespace {

// Servers before 0.2 send only the names of original files, with the clip.
const std::string& FileNameOf(const v1::ExportClipHeader& header) {
  return header.file_name().empty() ? header.clip().file_name() : header.file_name();
}

}  // namespace

absl::StatusOr<ExportedClip> Client::ExportClip(const v1::ExportClipRequest& request,
                                                CallOptions options) const {
  ExportedClip clip;
  ExportSink sink;
  sink.on_header = [&](const v1::ExportClipHeader& header) {
    clip.file_name = FileNameOf(header);
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
    header.set_file_name(FileNameOf(received));
    const std::string& name = header.file_name();
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
