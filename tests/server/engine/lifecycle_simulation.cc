// The events of the simulation and its simulated server process.
#include "tests/server/engine/lifecycle_simulation.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>
#include <utility>

#include "server/engine/ingest.h"
#include "server/engine/marker_schemes.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests {
namespace {

using std::chrono::milliseconds;
using storage::OperationState;

constexpr core::BuildSettings kSimulatedSettings{.frame_rate_hz = 60, .min_frames = 4};

struct SimulatedCrash {};

}  // namespace

LifecycleSimulation::Process::Process(const std::string& path)
    : store(*storage::SqliteMotionStore::Open(path)), operations(*store) {}

LifecycleSimulation::LifecycleSimulation(unsigned seed) : random_(seed), executor_(seed) {
  spdlog::set_level(spdlog::level::off);
  options_.rebuild_delay = milliseconds(300);
  options_.rebuild_delay_limit = milliseconds(2000);
  options_.extend_from = std::chrono::duration<double>(seed % 2 == 0 ? 0 : 3600);
  options_.model_memory_bytes = seed % 4 < 2 ? 0 : 1;  // 1: the model is evicted, and read again
  process_.emplace(directory_ / "store.db");
  REQUIRE(store()
              .CreateDatabase({.name = "db",
                               .settings = kSimulatedSettings,
                               .marker_set = server::kSourceMarkerSet})
              .ok());
  Serve();
  executor_.between = [this] { Meanwhile(); };
}

void LifecycleSimulation::Step() {
  switch (const int event = Below(6)) {
    case 3:
      if (Below(4) == 0) in_flight_.push_back(NewIngest());
      return;
    case 4:
      if (in_flight_.empty()) return;
      in_flight_.pop_back();
      last_request_ = executor_.Now();
      return;
    case 5:
      executor_.RunUntil(executor_.Now() + milliseconds(Below(500)));
      return;
    default:
      Change(event == 0 && Below(2) == 0 ? 3 + Below(2) : event);
  }
}

void LifecycleSimulation::CrashAndRestart() {
  Ingest();
  crash_in_ = 1 + Below(600);
  try {
    executor_.RunUntil(executor_.Now() + milliseconds(5000));
  } catch (const SimulatedCrash&) {
  }
  crash_in_ = 0;
  in_flight_.clear();
  process_.reset();
  process_.emplace(directory_ / "store.db");
  for (const std::string& clip : clips_) CHECK(store().GetClip("db", clip).ok());
  Serve();
  previous_.reset();
  // The database is not visible meanwhile.
  const auto between = std::exchange(executor_.between, nullptr);
  lifecycle().LoadStored();
  executor_.between = between;
  CHECK(corruptions_.List().empty());
  // The stored model is older than the changes since its build.
  const bool was_emptied = is_emptied_since_;
  const bool was_deleted = is_deleted_since_;
  CheckServed();
  is_emptied_since_ = was_emptied;
  is_deleted_since_ = was_deleted;
  // Like Engine::Load.
  auto undone = *store().ListOperations("db", "", 1000);
  std::erase_if(undone, [](const auto& operation) { return operation.done(); });
  std::ranges::reverse(undone);
  for (const auto& operation : undone) {
    lifecycle().Resume(operations().Adopt(operation)->id);
    first_request_[operation.id] = last_request_ = executor_.Now();
    started_.erase(operation.id);
  }
  if (undone.empty() && !*lifecycle().IsUpToDate()) Ask(*lifecycle().Request());
}

void LifecycleSimulation::Serve() {
  auto live = std::make_shared<server::LiveDatabase>("db", kSimulatedSettings);
  live->SetLifecycle(std::make_unique<server::ModelLifecycle>(
      *live, server::LifecycleServices{store(), operations(), corruptions_, executor_, options_}));
  const auto record = store().GetDatabase("db");
  REQUIRE(record.ok());
  server::MarkerSchemes schemes;
  live->set_scheme(schemes.Of(*record));
  process_->live = std::move(live);
}

bool LifecycleSimulation::InBuild(const std::function<bool()>& event) {
  int steps_left = 1 + Below(150);
  bool happened = false;
  executor_.between = [&] {
    if (--steps_left <= 0 && !happened) happened = event();
  };
  executor_.RunUntil(executor_.Now() + std::chrono::hours(1));
  executor_.between = nullptr;
  return happened;
}

void LifecycleSimulation::Ask(const storage::OperationRecord& operation) {
  CHECK(operation.state == OperationState::kPending);
  // An operation that waits since a restart is joined again after later ones were cancelled.
  if (std::ranges::find(requested_, operation.id) == requested_.end()) {
    requested_.push_back(operation.id);
    first_request_[operation.id] = executor_.Now();
  }
  last_request_ = executor_.Now();
}

void LifecycleSimulation::Ingest() {
  const auto in_flight = NewIngest();
  storage::NewClip clip;
  clip.record.file_name = "walk.bvh";
  clip.id_is_fixed = true;
  clip.record.id = "walk" + std::to_string(clip_count_);
  clip.file_bytes = WriteBvh({.frame_count = 20, .phase = 0.1 * clip_count_++});
  const auto stored = [&](const storage::ClipRecord& record) {
    clips_.insert(record.id);
    lifecycle().RequestUpdate();
    const auto operation = lifecycle().Request();
    REQUIRE(operation.ok());
    Ask(*operation);
    return absl::OkStatus();
  };
  const auto ingested = server::IngestClip(store(), *process_->live, {std::move(clip)}, options_,
                                           core::RunSerially, {}, stored);
  INFO(ingested.status().ToString());
  REQUIRE(ingested.ok());
  last_request_ = executor_.Now();
}

void LifecycleSimulation::Delete() {
  if (clips_.empty()) return;
  const auto clip = std::next(clips_.begin(), Below(static_cast<int>(clips_.size())));
  REQUIRE(store().DeleteClip("db", *clip).ok());
  clips_.erase(clip);
  is_deleted_since_ = true;
  is_emptied_since_ = is_emptied_since_ || clips_.empty();
  lifecycle().PurgeUnlessBuilding();
  const auto operation = lifecycle().Request();
  REQUIRE(operation.ok());
  Ask(*operation);
}

void LifecycleSimulation::Cancel() {
  if (requested_.empty()) return;
  const std::string& id =
      requested_[requested_.size() - 1 -
                 static_cast<std::size_t>(Below(std::min<int>(2, std::ssize(requested_))))];
  const auto before = operations().Get(id)->state;
  const auto is_first = lifecycle().Cancel(id);
  REQUIRE(is_first.ok());
  if (*is_first) cancelled_.insert(id);
  if (before == OperationState::kPending) {
    CHECK(*is_first);
    CHECK(operations().Get(id)->state == OperationState::kCancelled);
  }
  const auto snapshot = lifecycle().snapshot();
  if (*is_first && before == OperationState::kRunning && snapshot && !snapshot->is_stored()) {
    ++statistics_.cancelled_borrowing;
  }
}

void LifecycleSimulation::Meanwhile() {
  if (crash_in_ > 0 && --crash_in_ == 0) throw SimulatedCrash();
  int running = 0;
  for (const std::string& id : requested_) {
    if (operations().Get(id)->state != OperationState::kRunning) continue;
    ++running;
    if (!started_.insert(id).second) continue;
    ++statistics_.builds;
    CheckBegin(id);
  }
  CHECK(running <= 1);
  CheckServed();
  Change(Below(200));
}

void LifecycleSimulation::Change(int event) {
  if (event == 0) Ingest();
  if (event == 1) Delete();
  if (event == 2) Cancel();
  if (event == 3 && options_.model_memory_bytes > 0) statistics_.evictions += lifecycle().Evict();
  if (event == 4) lifecycle().Use().IgnoreError();
}

}  // namespace motiondb::tests
