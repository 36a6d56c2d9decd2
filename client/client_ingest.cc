// Files going in: a header, then blocks.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "client/connection.h"

namespace motiondb::client {
namespace {

BlockReader BlocksOf(std::string_view bytes) {
  return [bytes](std::string& block) mutable {
    block.assign(bytes.substr(0, kBlockBytes));
    bytes.remove_prefix(block.size());
    return absl::OkStatus();
  };
}

BlockReader BlocksOf(std::ifstream& file, const std::filesystem::path& path) {
  return [&file, path](std::string& block) {
    block.resize(kBlockBytes);
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    if (file.bad()) return absl::UnknownError(fmt::format("{}: cannot be read", path.string()));
    block.resize(static_cast<size_t>(file.gcount()));
    return absl::OkStatus();
  };
}

absl::Status OpenFile(const std::filesystem::path& path, std::ifstream& file) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    return absl::NotFoundError(fmt::format("{}: no such file", path.string()));
  }
  if (std::filesystem::is_directory(status)) {
    return absl::InvalidArgumentError(fmt::format("{}: is a folder, not a file", path.string()));
  }
  file.open(path, std::ios::binary);
  if (!file) return absl::UnknownError(fmt::format("{}: cannot be opened", path.string()));
  return absl::OkStatus();
}

// Sends all blocks. A stream that the server has ended early is not an error here: how the call
// finishes says why.
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
    const v1::IngestClipHeader& header, const BlockReader& file, const BlockReader& skeleton,
    const CallOptions& options) const {
  grpc::ClientContext context;
  Prepare(context, options);
  v1::IngestClipResponse response;
  const auto writer = clips->IngestClip(&context, &response);
  v1::IngestClipRequest first;
  *first.mutable_header() = header;
  absl::Status sent;
  if (writer->Write(first)) {
    sent = Send(*writer, skeleton, [](auto& message) { return message.mutable_skeleton_block(); });
    if (sent.ok()) {
      sent = Send(*writer, file, [](auto& message) { return message.mutable_file_block(); });
    }
  }
  // A file that could not be read to its end must not be stored in part.
  if (!sent.ok()) context.TryCancel();
  writer->WritesDone();
  const grpc::Status finished = writer->Finish();
  if (!sent.ok()) return sent;
  if (const absl::Status status = Finish(finished, options); !status.ok()) return status;
  return response;
}

absl::StatusOr<v1::IngestClipResponse> Client::IngestFile(const v1::IngestClipHeader& header,
                                                          const std::filesystem::path& file,
                                                          const std::filesystem::path& skeleton,
                                                          CallOptions options) const {
  std::ifstream file_stream, skeleton_stream;
  if (const absl::Status status = OpenFile(file, file_stream); !status.ok()) return status;
  v1::IngestClipHeader named = header;
  if (named.file_name().empty()) named.set_file_name(file.filename().string());
  BlockReader skeleton_blocks = BlocksOf(std::string_view());
  if (!skeleton.empty()) {
    if (const absl::Status status = OpenFile(skeleton, skeleton_stream); !status.ok())
      return status;
    if (named.skeleton_file_name().empty()) {
      named.set_skeleton_file_name(skeleton.filename().string());
    }
    skeleton_blocks = BlocksOf(skeleton_stream, skeleton);
  }
  return connection_->Ingest(named, BlocksOf(file_stream, file), skeleton_blocks, options);
}

absl::StatusOr<v1::IngestClipResponse> Client::IngestBytes(const v1::IngestClipHeader& header,
                                                           std::string_view file,
                                                           std::string_view skeleton,
                                                           CallOptions options) const {
  return connection_->Ingest(header, BlocksOf(file), BlocksOf(skeleton), options);
}

}  // namespace motiondb::client
