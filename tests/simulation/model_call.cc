#include "tests/simulation/model_call.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "server/engine/work/work_options.h"

namespace motiondb::simulation {

absl::StatusOr<server::ServedModel> ModelCall::Send(std::int64_t min_revision, Time end) {
  min_revision_ = min_revision;
  World& world = World::Current();
  world.Sleep(world.Between(microseconds(100), milliseconds(3)));
  if (server_runs()) Post();
  while (!has_result_ && server_runs() && world.now() < end) {
    waiting_.WaitUntil(std::min(end, world.now() + milliseconds(500)));
  }
  if (!has_result_ && !server_runs()) return absl::UnavailableError("the server has ended");
  return result_;
}

void ModelCall::Post() {
  engine_->workers().Post(server::Pool::kRequests, [self = shared_from_this()] { self->Run(); });
}

void ModelCall::Run() {
  has_changed_ = false;
  auto result = Try();
  if (!server::IsAwaitingChange(result.status())) {
    result_ = std::move(result);
    has_result_ = true;
    waiting_.WakeAll();
  } else if (!has_changed_) {
    is_parked_ = true;
  } else if (server_runs()) {
    Post();
  }
}

absl::StatusOr<server::ServedModel> ModelCall::Try() {
  const DatabaseLife* const life = history_.Find(database_);
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, engine_->FindDatabase(database_));
  server::WorkOptions terms;
  terms.wake_on = [this](server::ChangeSignal& signal) { WakeOn(signal); };
  if (min_revision_ > 0) WakeOn(*live->signal());
  auto served = engine_->CurrentModelAndRevision(*live, terms);
  const std::string what = fmt::format("call of {} at server {}", database_, process_->name);
  if (absl::IsDataLoss(served.status())) {
    World::Current().Fail(fmt::format("{}: {}", what, served.status().ToString()));
  }
  if (!served.ok()) return served;
  if (served->revision < min_revision_) return server::AwaitsChange();
  if (served->snapshot == nullptr) World::Current().Fail(what + ": no model");
  if (life != nullptr && cluster_.LifeOf(server_, live.get()) == life->id) {
    history_.CheckServed(what, life->id, *served);
  }
  return served;
}

void ModelCall::WakeOn(server::ChangeSignal& signal) {
  auto& subscription = subscriptions_[&signal];
  if (subscription == nullptr) subscription = signal.Subscribe([this] { OnChange(); });
}

void ModelCall::OnChange() {
  has_changed_ = true;
  if (std::exchange(is_parked_, false) && server_runs()) Post();
}

}  // namespace motiondb::simulation
