#include "server/rpc/restore_reactor.h"

#include <atomic>
#include <memory>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/store.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/silence_limit.h"
#include "server/translate/field_violation.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

class RestoreReactor final : public grpc::ServerReadReactor<v1::RestoreStoreRequest> {
 public:
  RestoreReactor(CallHost& host, grpc::CallbackServerContext& context,
                 v1::RestoreStoreResponse& response)
      : entry_(host, context, MethodOf<v1::RestoreStoreRequest>()),
        engine_(host.engine),
        response_(response),
        silence_(engine_.workers().request_executor(), host.limits.options().longest_silence,
                 [this] { EndSilence(); }) {
    if (grpc::Status admission = entry_.Admission(); !admission.ok()) {
      End(std::move(admission));
      return;
    }
    Read();
  }

  void OnReadDone(bool ok) override {
    if (!reading_.exchange(false)) return;  // the call has ended meanwhile
    entry_.Post([this, ok] {
      grpc::Status status =
          RunHandler(entry_.cancelled(), [this, ok] { return ok ? Take() : Restore(); });
      if (!ok || !status.ok()) return End(std::move(status));
      Read();
    });
  }
  void OnDone() override { delete this; }

 private:
  void Read() {
    silence_.Restart();
    reading_ = true;
    StartRead(&message_);
  }

  void EndSilence() {
    if (reading_.exchange(false)) End(entry_.Silent());
  }

  void End(grpc::Status status) { Finish(entry_.End(std::move(status))); }

  absl::Status Take() {
    if (restore_ == nullptr) {
      MOTIONDB_RETURN_IF_ERROR(entry_.Check(message_));
      MOTIONDB_ASSIGN_OR_RETURN(restore_, engine_.store().upkeep().BeginRestore());
    } else {
      MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
    }
    if (message_.block().size() > kBlockBytes) {
      return FieldViolation("block", "expected at most {} bytes, got {}", kBlockBytes,
                            message_.block().size());
    }
    return AtField("block", restore_->Append(message_.block()));
  }

  absl::Status Restore() {
    if (restore_ == nullptr) {
      MOTIONDB_RETURN_IF_ERROR(entry_.Check(message_));
      return FieldViolation("block", "expected the bytes of a backup, got none");
    }
    const auto restored = engine_.Restore(*restore_);
    if (!restored.ok()) return AtField("block", restored.status());
    response_.set_database_count(restored->database_count);
    response_.set_clip_count(static_cast<std::int32_t>(restored->clip_count));
    return absl::OkStatus();
  }

  CallEntry entry_;
  Engine& engine_;
  v1::RestoreStoreResponse& response_;
  v1::RestoreStoreRequest message_;
  std::unique_ptr<storage::StoreRestore> restore_;
  std::atomic<bool> reading_ = false;  // a read is under way, and the call has not ended
  SilenceLimit silence_;               // last: it calls what is above
};

}  // namespace

grpc::ServerReadReactor<v1::RestoreStoreRequest>* NewRestoreReactor(
    CallHost& host, grpc::CallbackServerContext& context, v1::RestoreStoreResponse& response) {
  return new RestoreReactor(host, context, response);
}

}  // namespace motiondb::server
