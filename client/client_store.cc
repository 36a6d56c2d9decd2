// The store as a whole: checked, copied, filled.
#include <fmt/format.h>

#include "client/backup_file.h"
#include "client/connection.h"
#include "client/input_file.h"

namespace motiondb::client {
namespace {

double Share(double part, double whole) { return whole > 0 ? part / whole : 0; }

}  // namespace

absl::StatusOr<v1::VerifySummary> Client::VerifyStore(
    const std::function<absl::Status(const v1::VerifyStoreResponse&)>& on_message,
    CallOptions options) const {
  v1::VerifySummary summary;
  bool ended = false;
  const std::function<absl::Status(const v1::VerifyStoreResponse&)> keep =
      [&](const v1::VerifyStoreResponse& message) {
        if (message.has_summary()) {
          summary = message.summary();
          ended = true;
        }
        return on_message ? on_message(message) : absl::OkStatus();
      };
  const absl::Status status =
      connection_->ReadStream(*connection_->store, &v1::StoreService::Stub::VerifyStore,
                              v1::VerifyStoreRequest(), keep, options);
  if (!status.ok()) return status;
  if (!ended) return absl::DataLossError("the verification ended without a summary");
  return summary;
}

absl::StatusOr<std::int64_t> Client::BackupStore(const std::filesystem::path& path, bool overwrite,
                                                 const std::function<void(double)>& on_progress,
                                                 CallOptions options) const {
  BackupFile file;
  if (const absl::Status opened = file.Open(path, overwrite); !opened.ok()) return opened;
  double total = 0;
  const std::function<absl::Status(const v1::BackupStoreResponse&)> take =
      [&](const v1::BackupStoreResponse& message) {
        if (message.total_bytes() > 0) total = static_cast<double>(message.total_bytes());
        const absl::Status written = file.Append(message.block());
        if (written.ok() && on_progress) {
          on_progress(Share(static_cast<double>(file.bytes()), total));
        }
        return written;
      };
  const absl::Status status =
      connection_->ReadStream(*connection_->store, &v1::StoreService::Stub::BackupStore,
                              v1::BackupStoreRequest(), take, options);
  if (!status.ok()) return status;
  if (const absl::Status whole = file.Complete(); !whole.ok()) return whole;
  return file.bytes();
}

absl::StatusOr<v1::RestoreStoreResponse> Client::RestoreStore(
    const std::filesystem::path& path, const std::function<void(double)>& on_progress,
    CallOptions options) const {
  auto file = InputFile::Open(path);
  if (!file.ok()) return file.status();
  if (!file->size()) {
    return absl::InvalidArgumentError(fmt::format("{}: is no regular file", path.string()));
  }

  OutgoingCall call(options);
  connection_->Prepare(call);
  v1::RestoreStoreResponse response;
  const auto writer = connection_->store->RestoreStore(&call.context, &response);
  v1::RestoreStoreRequest message;
  double sent = 0;
  absl::Status read;
  while (true) {
    read = file->Read(kBlockBytes, *message.mutable_block());
    // How the call finishes says why it was ended early.
    if (!read.ok() || message.block().empty() || !writer->Write(message)) break;
    sent += static_cast<double>(message.block().size());
    if (on_progress) on_progress(Share(sent, static_cast<double>(*file->size())));
  }
  if (!read.ok()) call.context.TryCancel();
  writer->WritesDone();
  const grpc::Status finished = writer->Finish();
  if (!read.ok()) return read;
  if (const absl::Status status = connection_->Finish(finished, call); !status.ok()) return status;
  return response;
}

}  // namespace motiondb::client
