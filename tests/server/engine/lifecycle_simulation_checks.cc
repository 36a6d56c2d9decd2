// The guarantees that the simulation checks.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <iterator>
#include <utility>

#include "server/engine/snapshot.h"
#include "tests/server/engine/lifecycle_simulation.h"

namespace motiondb::tests {
namespace {

using server::Calibration;
using storage::OperationState;

std::set<std::string> KnownTo(const server::Snapshot& snapshot) {
  std::set<std::string> known;
  for (const auto& clip : snapshot.model.clips()) known.insert(clip.id);
  return known;
}

}  // namespace

void LifecycleSimulation::CheckEnd() {
  executor_.between = nullptr;
  in_flight_.clear();
  Ingest();
  executor_.RunUntil(executor_.Now() + std::chrono::hours(1));
  for (const std::string& id : requested_) {
    const auto operation = operations().Get(id);
    REQUIRE(operation.ok());
    CHECK(operation->done());
    CHECK((operation->state == OperationState::kSucceeded || cancelled_.contains(id)));
  }
  CHECK(lifecycle().operation().empty());
  lifecycle().Use().IgnoreError();
  executor_.RunUntil(executor_.Now() + std::chrono::seconds(1));
  const auto snapshot = lifecycle().snapshot();
  REQUIRE(snapshot != nullptr);
  CHECK(snapshot->is_stored());
  CHECK(KnownTo(*snapshot) == clips_);
  CheckServed();
}

void LifecycleSimulation::CheckStop() {
  Ingest();
  const std::string waiting = requested_.back();
  lifecycle().BeginStop();
  executor_.RunUntil(executor_.Now() + std::chrono::hours(1));
  lifecycle().AwaitStop();
  CHECK(operations().Get(waiting)->state == OperationState::kPending);
}

bool LifecycleSimulation::CheckDrainInBuild() {
  Ingest();
  const std::string id = requested_.back();
  std::shared_ptr<const server::Snapshot> served;
  const bool happened = InBuild([&] {
    served = lifecycle().snapshot();
    lifecycle().BeginStop();
    return true;
  });
  if (!happened) return false;
  lifecycle().AwaitStop();
  CHECK(operations().Get(id)->state == OperationState::kPending);
  CHECK(lifecycle().snapshot() == served);
  return true;
}

bool LifecycleSimulation::CheckDeletionInBuild() {
  Ingest();
  const auto deletion = [this] {
    REQUIRE(store().DeleteDatabase("db").ok());
    lifecycle().Forget();
    return absl::OkStatus();
  };
  // Waiting for a model that is being stored would block this thread.
  const bool happened =
      InBuild([&] { return process_->live->Retire(deletion, [] { return true; }).ok(); });
  if (!happened) return false;
  lifecycle().AwaitStop();
  CHECK(lifecycle().snapshot() == nullptr);
  CHECK(absl::IsNotFound(store().GetDatabase("db").status()));
  return true;
}

void LifecycleSimulation::CheckBegin(const std::string& id) {
  // A model that is read and found outdated requests a build by itself.
  if (options_.model_memory_bytes > 0) return;
  const auto latest = first_request_.at(id) + options_.rebuild_delay_limit;
  const auto now = executor_.Now();
  CHECK((now >= latest || (in_flight_.empty() && now >= last_request_ + options_.rebuild_delay)));
}

void LifecycleSimulation::CheckServed() {
  if (const auto unloaded = lifecycle().served().unloaded; unloaded != nullptr) {
    CHECK(lifecycle().snapshot() == nullptr);
    const auto newest = *store().ListModels("db", 0, 1);
    REQUIRE(!newest.empty());
    CHECK(unloaded->version == newest.front().version);
    CHECK(unloaded->clip_count == newest.front().clip_count);
    return;
  }
  const auto now = lifecycle().snapshot();
  const auto before = std::exchange(previous_, now);
  const bool was_emptied = is_emptied_since_;
  const bool was_deleted = is_deleted_since_;
  if (now == nullptr) {
    CHECK((before == nullptr || was_emptied || clips_.empty()));
    return;
  }
  const std::set<std::string> known = KnownTo(*now);
  // The build of a model that has only deleted clips began before the last deletion.
  const auto is_stored = [this](const std::string& clip) { return clips_.contains(clip); };
  if (now != before && std::ranges::any_of(known, is_stored)) is_emptied_since_ = false;
  if (now != before) is_deleted_since_ = false;
  CheckVersion(*now);
  const bool is_successor = before != nullptr && !was_emptied;
  if (is_successor) CHECK(now->record.version >= before->record.version);
  if (is_successor && !was_deleted && now != before) {
    std::set<std::string> lost;
    std::ranges::set_difference(KnownTo(*before), known, std::inserter(lost, lost.end()));
    for (const std::string& clip : lost) CHECK(!clips_.contains(clip));
  }
  if (now->is_stored()) {
    last_own_ = now->model.recognition();
    return;
  }
  ++statistics_.borrowing;
  if (now->record.added_clip_count > 0) ++statistics_.extended_borrowing;
  const bool is_previous = now->calibration == Calibration::kPrevious;
  const core::RecognitionCalibration expected = is_previous ? last_own_ : decltype(last_own_)();
  CHECK(now->model.recognition().window.familiarity == expected.window.familiarity);
  CHECK(now->model.recognition().window.weight.scale == expected.window.weight.scale);
  CHECK(now->model.recognition().whole.weight.power == expected.whole.weight.power);
}

void LifecycleSimulation::CheckVersion(const server::Snapshot& snapshot) {
  const auto& record = snapshot.record;
  CHECK(record.clip_count == std::ssize(snapshot.model.clips()));
  const auto newest = *store().ListModels("db", 0, 1);
  if (record.version == 0) {
    CHECK(!snapshot.is_stored());
    return;
  }
  REQUIRE(!newest.empty());
  CHECK(record.version <= newest.front().version);
  if (!snapshot.is_stored()) return;
  CHECK(record.version == newest.front().version);
  CHECK(record.create_time_us == newest.front().create_time_us);
  CHECK(record.clip_count == newest.front().clip_count);
}

}  // namespace motiondb::tests
