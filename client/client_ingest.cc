// Files going in: a header, then blocks.
#include <utility>

#include "client/connection.h"
#include "client/input_file.h"

namespace motiondb::client {
namespace {

BlockReader BlocksOf(std::string_view bytes) {
  return [bytes](std::string& block) mutable {
    block.assign(bytes.substr(0, kBlockBytes));
    bytes.remove_prefix(block.size());
    return absl::OkStatus();
  };
}

BlockReader BlocksOf(InputFile& file) {
  return [&file](std::string& block) { return file.Read(kBlockBytes, block); };
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
  OutgoingCall call(options);
  Prepare(call);
  v1::IngestClipResponse response;
  const auto writer = clips->IngestClip(&call.context, &response);
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
  if (!sent.ok()) call.context.TryCancel();
  writer->WritesDone();
  const grpc::Status finished = writer->Finish();
  if (!sent.ok()) return sent;
  if (const absl::Status status = Finish(finished, call); !status.ok()) return status;
  return response;
}

absl::StatusOr<v1::IngestClipResponse> Client::IngestFile(const v1::IngestClipHeader& header,
                                                          const std::filesystem::path& file,
                                                          const std::filesystem::path& skeleton,
                                                          CallOptions options) const {
  auto opened = InputFile::Open(file);
  if (!opened.ok()) return opened.status();
  v1::IngestClipHeader named = header;
  if (named.file_name().empty()) named.set_file_name(file.filename().string());
  if (skeleton.empty()) {
    return connection_->Ingest(named, BlocksOf(*opened), BlocksOf(std::string_view()), options);
  }
  auto opened_skeleton = InputFile::Open(skeleton);
  if (!opened_skeleton.ok()) return opened_skeleton.status();
  if (named.skeleton_file_name().empty()) {
    named.set_skeleton_file_name(skeleton.filename().string());
  }
  return connection_->Ingest(named, BlocksOf(*opened), BlocksOf(*opened_skeleton), options);
}

absl::StatusOr<v1::IngestClipResponse> Client::IngestBytes(const v1::IngestClipHeader& header,
                                                           std::string_view file,
                                                           std::string_view skeleton,
                                                           CallOptions options) const {
  return connection_->Ingest(header, BlocksOf(file), BlocksOf(skeleton), options);
}

}  // namespace motiondb::client
