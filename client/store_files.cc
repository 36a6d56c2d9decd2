// Verify; backup and restore of the store; export and import of a database.

#include <fmt/format.h>

#include "client/backup_file.h"
#include "client/connection.h"
#include "client/input_file.h"

namespace motiondb::client {

namespace {

using Progress = std::function<void(double)>;

double Share(double part, double whole) { return whole > 0 ? part / whole : 0; }

// Writes the blocks of a stream of `Response` to a backup file and returns its size.
template <typename Response, typename Connection, typename Method, typename Request>
absl::StatusOr<std::int64_t> ReceiveFile(const Connection& connection, Method method,
                                         const Request& request, const std::filesystem::path& path,
                                         bool overwrite, const Progress& on_progress,
                                         const CallOptions& options) {
  BackupFile file;
  if (const absl::Status opened = file.Open(path, overwrite); !opened.ok()) return opened;
  double total = 0;
  const std::function<absl::Status(const Response&)> append_block = [&](const Response& message) {
    if (message.total_bytes() > 0) total = static_cast<double>(message.total_bytes());
    const absl::Status written = file.Append(message.block());
    if (written.ok() && on_progress) on_progress(Share(static_cast<double>(file.bytes()), total));
    return written;
  };
  const absl::Status status =
      connection.ReadStream(&Endpoint::store, method, request, append_block, options);
  if (!status.ok()) return status;
  if (const absl::Status whole = file.Complete(); !whole.ok()) return whole;
  return file.bytes();
}

// Sends a backup file in blocks. `first`: the first message, without a block.
template <typename Response, typename Connection, typename Method, typename Request>
absl::StatusOr<Response> SendFile(const Connection& connection, Method method, const Request& first,
                                  const std::filesystem::path& path, const Progress& on_progress,
                                  const CallOptions& options) {
  Response response;
  // An attempt opens the file, since an earlier one may have read blocks that no server has got.
  const auto attempt = [&](OutgoingCall& call) -> absl::Status {
    auto file = InputFile::Open(path);
    if (!file.ok()) return file.status();
    if (!file->size()) {
      return absl::InvalidArgumentError(fmt::format("{}: is not a regular file", path.string()));
    }
    const auto writer = (call.endpoint.store.get()->*method)(&call.context, &response);
    Request message = first;
    double sent = 0;
    absl::Status read;
    while (true) {
      read = file->Read(kBlockBytes, *message.mutable_block());
      // If Write fails, Finish returns the reason.
      if (!read.ok() || message.block().empty() || !writer->Write(message)) break;
      sent += static_cast<double>(message.block().size());
      if (on_progress) on_progress(Share(sent, static_cast<double>(*file->size())));
      message.Clear();
    }
    if (!read.ok()) call.context.TryCancel();
    writer->WritesDone();
    const grpc::Status finished = writer->Finish();
    return read.ok() ? connection.Finish(finished, call) : read;
  };
  const absl::Status status = connection.Run(Effect::kChange, options, DatabaseOf(first), attempt);
  if (!status.ok()) return status;
  return response;
}

}  // namespace

absl::StatusOr<v1::VerifySummary> Client::VerifyStore(
    const std::function<absl::Status(const v1::VerifyStoreResponse&)>& on_message,
    CallOptions options) const {
  v1::VerifySummary summary;
  bool ended = false;
  const std::function<absl::Status(const v1::VerifyStoreResponse&)> handle_message =
      [&](const v1::VerifyStoreResponse& message) {
        if (message.has_summary()) {
          summary = message.summary();
          ended = true;
        }
        return on_message ? on_message(message) : absl::OkStatus();
      };
  const absl::Status status =
      connection_->ReadStream(&Endpoint::store, &v1::StoreService::Stub::VerifyStore,
                              v1::VerifyStoreRequest(), handle_message, options);
  if (!status.ok()) return status;
  if (!ended) return absl::DataLossError("the verification ended without a summary");
  return summary;
}

absl::StatusOr<std::int64_t> Client::BackupStore(const std::filesystem::path& path, bool overwrite,
                                                 const Progress& on_progress,
                                                 CallOptions options) const {
  return ReceiveFile<v1::BackupStoreResponse>(*connection_, &v1::StoreService::Stub::BackupStore,
                                              v1::BackupStoreRequest(), path, overwrite,
                                              on_progress, options);
}

absl::StatusOr<std::int64_t> Client::ExportDatabase(const v1::ExportDatabaseRequest& request,
                                                    const std::filesystem::path& path,
                                                    bool overwrite, const Progress& on_progress,
                                                    CallOptions options) const {
  return ReceiveFile<v1::ExportDatabaseResponse>(*connection_,
                                                 &v1::StoreService::Stub::ExportDatabase, request,
                                                 path, overwrite, on_progress, options);
}

absl::StatusOr<v1::RestoreStoreResponse> Client::RestoreStore(const std::filesystem::path& path,
                                                              const Progress& on_progress,
                                                              CallOptions options) const {
  return SendFile<v1::RestoreStoreResponse>(*connection_, &v1::StoreService::Stub::RestoreStore,
                                            v1::RestoreStoreRequest(), path, on_progress, options);
}

absl::StatusOr<v1::ImportDatabaseResponse> Client::ImportDatabase(const std::filesystem::path& path,
                                                                  const std::string& database_id,
                                                                  const Progress& on_progress,
                                                                  CallOptions options) const {
  v1::ImportDatabaseRequest first;
  first.set_database_id(database_id);
  return SendFile<v1::ImportDatabaseResponse>(*connection_, &v1::StoreService::Stub::ImportDatabase,
                                              first, path, on_progress, options);
}

}  // namespace motiondb::client
