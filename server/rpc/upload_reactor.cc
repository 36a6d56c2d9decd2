#include "server/rpc/upload_reactor.h"

#include <memory>
#include <optional>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/store.pb.h"
#include "server/rpc/services.h"
#include "server/translate/ingest_stream.h"
#include "server/translate/message_fields.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {

namespace {

class IngestReactor final : public UploadReactor<v1::IngestClipRequest> {
 public:
  IngestReactor(ServiceContext& host, grpc::CallbackServerContext& context,
                v1::IngestClipResponse& response)
      : UploadReactor(host, context, ReceiveThread::kGrpcThread),
        engine_(host.engine),
        response_(response),
        stream_(engine_.options().max_file_bytes) {}

 private:
  absl::Status Take(v1::IngestClipRequest& message) override {
    MOTIONDB_RETURN_IF_ERROR(stream_.Take(std::move(message)));
    MOTIONDB_RETURN_IF_ERROR(entry().ReserveFile(stream_.byte_count()));
    if (database_ != nullptr) return absl::OkStatus();
    MOTIONDB_ASSIGN_OR_RETURN(database_, engine_.FindDatabase(stream_.database()));
    if (!stream_.validate_only()) {
      MOTIONDB_ASSIGN_OR_RETURN(in_flight_, engine_.BeginIngest(database_));
    }
    return absl::OkStatus();
  }

  bool NeedsImport() const override { return stream_.needs_import(); }

  absl::Status Import() override {
    MOTIONDB_ASSIGN_OR_RETURN(request_, stream_.Finish());
    return AtField("file_block", ImportBefore(*request_, Terms()));
  }

  absl::Status Answer() override {
    if (!request_) {
      MOTIONDB_ASSIGN_OR_RETURN(request_, stream_.Finish());
    }
    IngestRequest& request = *request_;
    const bool validate_only = request.validate_only;
    request.clip.author = entry().principal();
    request.clip.audit = [this](const storage::ClipRecord& record) {
      return entry().AuditRecordForChange(ClipName(record.database, record.id));
    };
    auto ingested = engine_.Ingest(database_, std::move(request), Terms());
    if (!ingested.ok()) return AtField("file_block", ingested.status());
    SetClip(ingested->clip, *response_.mutable_clip());
    if (validate_only) {
      entry().SetUnrecorded();
    } else {
      SetOperation(ingested->operation, *response_.mutable_operation());
    }
    in_flight_.reset();
    return absl::OkStatus();
  }

  WorkOptions Terms() {
    return {AllowedWork::kAllWork, entry().cancelled(),
            [this](std::int64_t bytes) { return entry().ReserveWork(bytes); }};
  }

  Engine& engine_;
  v1::IngestClipResponse& response_;
  IngestStream stream_;
  std::shared_ptr<LiveDatabase> database_;
  std::unique_ptr<ModelLifecycle::Ingest> in_flight_;
  std::optional<IngestRequest> request_;
};

}  // namespace

grpc::ServerReadReactor<v1::IngestClipRequest>* NewIngestReactor(
    ServiceContext& host, grpc::CallbackServerContext& context, v1::IngestClipResponse& response) {
  return new IngestReactor(host, context, response);
}

namespace {

class RestoreReactor final : public UploadReactor<v1::RestoreStoreRequest> {
 public:
  RestoreReactor(ServiceContext& host, grpc::CallbackServerContext& context,
                 v1::RestoreStoreResponse& response)
      : UploadReactor(host, context, ReceiveThread::kOnRequestThread),
        engine_(host.engine),
        response_(response) {}

 private:
  absl::Status Take(v1::RestoreStoreRequest& message) override {
    if (restore_ == nullptr) {
      MOTIONDB_ASSIGN_OR_RETURN(restore_, engine_.store().maintenance().BeginRestore());
    }
    if (message.block().size() > kMaxBlockBytes) {
      return FieldViolation("block", "expected at most {} bytes, got {}", kMaxBlockBytes,
                            message.block().size());
    }
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

}  // namespace motiondb::server
