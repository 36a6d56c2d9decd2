#include <memory>
#include <string>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/store.pb.h"
#include "server/rpc/receive_reactor.h"
#include "server/rpc/services.h"
#include "server/translate/ingest_stream.h"
#include "server/translate/message_fields.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {

namespace {

absl::Status CheckBlock(const std::string& block) {
  if (block.size() <= kMaxBlockBytes) return absl::OkStatus();
  return FieldViolation("block", "expected at most {} bytes, got {}", kMaxBlockBytes, block.size());
}

class RestoreReactor final : public ReceiveReactor<v1::RestoreStoreRequest> {
 public:
  RestoreReactor(ServiceContext& host, grpc::CallbackServerContext& context,
                 v1::RestoreStoreResponse& response)
      : ReceiveReactor(host, context, ReceiveThread::kOnRequestThread),
        engine_(host.engine),
        response_(response) {}

 private:
  absl::Status Take(v1::RestoreStoreRequest& message) override {
    if (restore_ == nullptr) {
      MOTIONDB_ASSIGN_OR_RETURN(restore_, engine_.store().maintenance().BeginRestore());
    }
    MOTIONDB_RETURN_IF_ERROR(CheckBlock(message.block()));
    return AtField("block", restore_->Append(message.block()));
  }

  absl::Status Answer() override {
    if (restore_ == nullptr) {
      return AtField("block", core::InvalidArgument("the backup is empty"));
    }
    const auto restored = engine_.Restore(*restore_, entry().cancelled());
    if (!restored.ok()) return AtField("block", restored.status());
    response_.set_database_count(restored->database_count);
    response_.set_clip_count(static_cast<std::int32_t>(restored->clip_count));
    return absl::OkStatus();
  }

  Engine& engine_;
  v1::RestoreStoreResponse& response_;
  std::unique_ptr<storage::StoreRestore> restore_;
};

}  // namespace

grpc::ServerReadReactor<v1::RestoreStoreRequest>* NewRestoreReactor(
    ServiceContext& host, grpc::CallbackServerContext& context,
    v1::RestoreStoreResponse& response) {
  return new RestoreReactor(host, context, response);
}

namespace {

class ImportDatabaseReactor final : public ReceiveReactor<v1::ImportDatabaseRequest> {
 public:
  ImportDatabaseReactor(ServiceContext& host, grpc::CallbackServerContext& context,
                        v1::ImportDatabaseResponse& response)
      : ReceiveReactor(host, context, ReceiveThread::kOnRequestThread),
        engine_(host.engine),
        response_(response) {}

 private:
  absl::Status Take(v1::ImportDatabaseRequest& message) override {
    if (import_ == nullptr) {
      database_ = message.database_id();
      if (!database_.empty()) {
        // Refuse before the client has sent the file.
        MOTIONDB_RETURN_IF_ERROR(CheckDatabaseId("database_id", database_));
        MOTIONDB_RETURN_IF_ERROR(engine_.CheckMayImport(database_));
      }
      MOTIONDB_ASSIGN_OR_RETURN(import_, engine_.store().maintenance().BeginImport());
    } else if (!message.database_id().empty()) {
      return FieldViolation("database_id", "expected only in the first message");
    }
    MOTIONDB_RETURN_IF_ERROR(CheckBlock(message.block()));
    return AtField("block", import_->Append(message.block()));
  }

  absl::Status Answer() override {
    if (import_ == nullptr) {
      return AtField("block", core::InvalidArgument("the exported database is empty"));
    }
    const auto content = import_->Check(entry().cancelled());
    if (!content.ok()) return AtField("block", content.status());
    if (database_.empty()) database_ = content->record.name;
    MOTIONDB_RETURN_IF_ERROR(CheckDatabaseId("database_id", database_));
    const auto audit = entry().AuditRecordForChange(DatabaseName(database_));
    MOTIONDB_RETURN_IF_ERROR(engine_.ImportDatabase(std::move(import_), *content, database_,
                                                    {&audit, entry().cancelled()}));
    response_.set_name(DatabaseName(database_));
    response_.set_clip_count(content->clip_count);
    return absl::OkStatus();
  }

  Engine& engine_;
  v1::ImportDatabaseResponse& response_;
  std::string database_;  // its id; empty: the exported one
  std::unique_ptr<storage::DatabaseImport> import_;
};

}  // namespace

grpc::ServerReadReactor<v1::ImportDatabaseRequest>* NewImportDatabaseReactor(
    ServiceContext& host, grpc::CallbackServerContext& context,
    v1::ImportDatabaseResponse& response) {
  return new ImportDatabaseReactor(host, context, response);
}

}  // namespace motiondb::server
