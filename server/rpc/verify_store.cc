#include "server/rpc/verify_store.h"

#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/translate/damage_message.h"

namespace motiondb::server {
namespace {

void SetSummary(const storage::VerifyTotals& totals, v1::VerifySummary& summary) {
  summary.set_database_count(totals.database_count);
  summary.set_clip_count(totals.clip_count);
  summary.set_model_count(totals.model_count);
  summary.set_skeleton_count(totals.skeleton_count);
  summary.set_byte_count(totals.byte_count);
  summary.set_damage_count(totals.damage_count);
}

// One verification: its findings as messages, and its progress in between.
class Verification {
 public:
  Verification(Engine& engine, std::unique_ptr<storage::StoreVerifier> verifier)
      : engine_(engine), verifier_(std::move(verifier)) {}

  absl::StatusOr<bool> Next(v1::VerifyStoreResponse& message) {
    if (summed_up_) return false;
    if (found_.empty() && more_) MOTIONDB_RETURN_IF_ERROR(Step());
    if (!found_.empty()) {
      SetDamage(found_.front(), *message.mutable_damage());
      found_.pop_front();
    } else if (more_) {
      message.set_progress(verifier_->progress());
    } else {
      SetSummary(verifier_->totals(), *message.mutable_summary());
      summed_up_ = true;
    }
    return true;
  }

 private:
  absl::Status Step() {
    std::vector<storage::Damage> found;
    MOTIONDB_ASSIGN_OR_RETURN(more_, verifier_->Step(found));
    for (storage::Damage& damage : found) {
      engine_.NoteDamage(damage);
      found_.push_back(std::move(damage));
    }
    return absl::OkStatus();
  }

  Engine& engine_;
  const std::unique_ptr<storage::StoreVerifier> verifier_;
  std::deque<storage::Damage> found_;  // not yet sent
  bool more_ = true;
  bool summed_up_ = false;
};

}  // namespace

absl::StatusOr<NextMessage<v1::VerifyStoreResponse>> OpenVerify(const Call& call,
                                                                const v1::VerifyStoreRequest&) {
  MOTIONDB_ASSIGN_OR_RETURN(auto verifier,
                            call.engine.store().upkeep().BeginVerify(call.cancelled));
  auto verification = std::make_shared<Verification>(call.engine, std::move(verifier));
  return [verification](v1::VerifyStoreResponse& message) { return verification->Next(message); };
}

}  // namespace motiondb::server
