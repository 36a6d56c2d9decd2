#include "server/rpc/restore_reactor.h"

#include <memory>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/store.pb.h"
#include "server/rpc/upload_reactor.h"
#include "server/translate/field_violation.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

class RestoreReactor final : public UploadReactor<v1::RestoreStoreRequest> {
 public:
  RestoreReactor(CallHost& host, grpc::CallbackServerContext& context,
                 v1::RestoreStoreResponse& response)
      : UploadReactor(host, context, Taking::kOnRequestThread),
        engine_(host.engine),
        response_(response) {}

 private:
  absl::Status Take(v1::RestoreStoreRequest& message) override {
    if (restore_ == nullptr) {
      MOTIONDB_ASSIGN_OR_RETURN(restore_, engine_.store().upkeep().BeginRestore());
    }
    if (message.block().size() > kBlockBytes) {
      return FieldViolation("block", "expected at most {} bytes, got {}", kBlockBytes,
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
    CallHost& host, grpc::CallbackServerContext& context, v1::RestoreStoreResponse& response) {
  return new RestoreReactor(host, context, response);
}

}  // namespace motiondb::server
