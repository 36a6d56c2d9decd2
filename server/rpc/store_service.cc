#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "motiondb/v1/store.grpc.pb.h"
#include "motiondb/v1/store.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

// Returns the blocks of a backup; `Response` has the fields `total_bytes` and `block`.
template <typename Response>
MessageSource<Response> BlocksOf(std::shared_ptr<storage::StoreBackup> backup) {
  return [backup = std::move(backup),
          first = true](Response& message) mutable -> absl::StatusOr<bool> {
    if (std::exchange(first, false)) message.set_total_bytes(backup->total_bytes());
    return backup->Read(*message.mutable_block());
  };
}

absl::StatusOr<MessageSource<v1::BackupStoreResponse>> OpenBackup(const Call& call,
                                                                  const v1::BackupStoreRequest&) {
  MOTIONDB_ASSIGN_OR_RETURN(auto backup,
                            call.engine.store().maintenance().BeginBackup(call.cancelled));
  return BlocksOf<v1::BackupStoreResponse>(std::move(backup));
}

absl::StatusOr<MessageSource<v1::ExportDatabaseResponse>> OpenDatabaseExport(
    const Call& call, const v1::ExportDatabaseRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(auto exported,
                            call.engine.store().maintenance().BeginExport(id, call.cancelled));
  return BlocksOf<v1::ExportDatabaseResponse>(std::move(exported));
}

void SetSummary(const storage::VerifyTotals& totals, v1::VerifySummary& summary) {
  summary.set_database_count(totals.database_count);
  summary.set_clip_count(totals.clip_count);
  summary.set_model_count(totals.model_count);
  summary.set_skeleton_count(totals.skeleton_count);
  summary.set_byte_count(totals.byte_count);
  summary.set_corruption_count(totals.corruption_count);
}

// Makes the messages of one verification: corrupt items, progress in between, and a summary.
class Verification {
 public:
  Verification(Engine& engine, std::unique_ptr<storage::StoreVerifier> verifier)
      : engine_(engine), verifier_(std::move(verifier)) {}

  absl::StatusOr<bool> Next(v1::VerifyStoreResponse& message) {
    if (summary_sent_) return false;
    if (found_.empty() && more_) MOTIONDB_RETURN_IF_ERROR(Step());
    if (!found_.empty()) {
      SetCorruption(found_.front(), *message.mutable_corruption());
      found_.pop_front();
    } else if (more_) {
      message.set_progress(verifier_->progress());
    } else {
      SetSummary(verifier_->totals(), *message.mutable_summary());
      summary_sent_ = true;
    }
    return true;
  }

 private:
  absl::Status Step() {
    std::vector<storage::Corruption> found;
    MOTIONDB_ASSIGN_OR_RETURN(more_, verifier_->Step(found));
    for (storage::Corruption& corruption : found) {
      engine_.ReportCorruption(corruption);
      found_.push_back(std::move(corruption));
    }
    return absl::OkStatus();
  }

  Engine& engine_;
  const std::unique_ptr<storage::StoreVerifier> verifier_;
  std::deque<storage::Corruption> found_;  // not sent yet
  bool more_ = true;
  bool summary_sent_ = false;
};

absl::StatusOr<MessageSource<v1::VerifyStoreResponse>> OpenVerify(const Call& call,
                                                                  const v1::VerifyStoreRequest&) {
  MOTIONDB_ASSIGN_OR_RETURN(auto verifier,
                            call.engine.store().maintenance().BeginVerify(call.cancelled));
  auto verification = std::make_shared<Verification>(call.engine, std::move(verifier));
  return [verification](v1::VerifyStoreResponse& message) { return verification->Next(message); };
}

class StoreServiceImpl final : public v1::StoreService::CallbackService {
 public:
  explicit StoreServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerWriteReactor<v1::VerifyStoreResponse>* VerifyStore(
      grpc::CallbackServerContext* context, const v1::VerifyStoreRequest* request) override {
    return new StreamReactor<v1::VerifyStoreRequest, v1::VerifyStoreResponse>(host_, context,
                                                                              request, OpenVerify);
  }
  grpc::ServerWriteReactor<v1::BackupStoreResponse>* BackupStore(
      grpc::CallbackServerContext* context, const v1::BackupStoreRequest* request) override {
    return new StreamReactor<v1::BackupStoreRequest, v1::BackupStoreResponse>(host_, context,
                                                                              request, OpenBackup);
  }
  grpc::ServerReadReactor<v1::RestoreStoreRequest>* RestoreStore(
      grpc::CallbackServerContext* context, v1::RestoreStoreResponse* response) override {
    return NewRestoreReactor(host_, *context, *response);
  }
  grpc::ServerWriteReactor<v1::ExportDatabaseResponse>* ExportDatabase(
      grpc::CallbackServerContext* context, const v1::ExportDatabaseRequest* request) override {
    return new StreamReactor<v1::ExportDatabaseRequest, v1::ExportDatabaseResponse>(
        host_, context, request, OpenDatabaseExport);
  }
  grpc::ServerReadReactor<v1::ImportDatabaseRequest>* ImportDatabase(
      grpc::CallbackServerContext* context, v1::ImportDatabaseResponse* response) override {
    return NewImportDatabaseReactor(host_, *context, *response);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeStoreService(ServiceContext& host) {
  return std::make_unique<StoreServiceImpl>(host);
}

}  // namespace motiondb::server
