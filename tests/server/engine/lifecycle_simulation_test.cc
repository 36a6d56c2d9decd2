// Random changes of a database, also in the midst of builds, in simulated time: what the states of
// its lifecycle promise (server/engine/model_lifecycle.h).
#include <spdlog/spdlog.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <vector>

#include "server/engine/ingest.h"
#include "server/engine/marker_schemes.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/snapshot.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/simulated_executor.h"
#include "tests/support/stick_figure.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {
namespace {

using server::Executor;
using server::Retiring;
using std::chrono::milliseconds;
using storage::OperationState;

class Simulation {
 public:
  explicit Simulation(unsigned seed) : random_(seed), executor_(seed) {
    spdlog::set_level(spdlog::level::off);
    options_.rebuild_delay = milliseconds(300);
    options_.rebuild_delay_limit = milliseconds(2000);
    options_.extend_from = std::chrono::duration<double>(seed % 2 == 0 ? 0 : 3600);
    const core::BuildSettings settings{.frame_rate_hz = 60, .min_frames = 4};
    REQUIRE(store_
                ->CreateDatabase(
                    {.name = "db", .settings = settings, .marker_set = server::kSourceMarkerSet})
                .ok());
    live_ = std::make_shared<server::LiveDatabase>("db", settings);
    live_->Serve(std::make_unique<server::ModelLifecycle>(
        *live_, server::LifecycleServices{*store_, operations_, executor_, options_}));
    executor_.between = [this] { Meanwhile(); };
  }

  // One event: a clip, a deletion, a cancellation, a slow ingest that begins or ends, or time.
  void Step() {
    switch (Below(6)) {
      case 0:
        return Ingest();
      case 1:
        return Delete();
      case 2:
        return Cancel();
      case 3:
        if (Below(4) == 0) in_flight_.push_back(NewIngest());
        return;
      case 4:
        if (in_flight_.empty()) return;
        in_flight_.pop_back();
        last_ask_ = executor_.Now();
        return;
      default:
        executor_.RunUntil(executor_.Now() + milliseconds(Below(500)));
    }
  }

  // All that was begun ends, and the model is of the clips there are.
  void CheckEnd() {
    executor_.between = nullptr;
    in_flight_.clear();
    Ingest();
    executor_.RunUntil(executor_.Now() + std::chrono::hours(1));
    int running = 0;
    for (const std::string& id : asked_) {
      const auto operation = operations_.Get(id);
      REQUIRE(operation.ok());
      CHECK(operation->done());
      CHECK((operation->state == OperationState::kSucceeded || cancelled_.contains(id)));
      running += operation->done() ? 0 : 1;
    }
    CHECK(running == 0);
    CHECK(live_->operation().empty());
    std::set<std::string> known;
    REQUIRE(live_->snapshot() != nullptr);
    for (const auto& clip : live_->snapshot()->model.clips()) known.insert(clip.id);
    CHECK(known == clips_);
  }

  // Nothing begins any more, and what waited is for the next server.
  void CheckStop() {
    Ingest();
    const std::string waiting = asked_.back();
    live_->lifecycle().BeginStop();
    executor_.RunUntil(executor_.Now() + std::chrono::hours(1));
    live_->lifecycle().AwaitStop();
    CHECK(operations_.Get(waiting)->state == OperationState::kPending);
  }

  int builds() const { return static_cast<int>(begun_.size()); }

 private:
  int Below(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }

  std::unique_ptr<server::ModelLifecycle::Ingest> NewIngest() {
    return std::make_unique<server::ModelLifecycle::Ingest>(live_);
  }

  void Ask(const storage::OperationRecord& operation) {
    CHECK(operation.state == OperationState::kPending);
    if (asked_.empty() || asked_.back() != operation.id) {
      asked_.push_back(operation.id);
      first_ask_[operation.id] = executor_.Now();
    }
    last_ask_ = executor_.Now();
  }

  void Ingest() {
    const auto in_flight = NewIngest();
    server::IngestFile file;
    file.file_name = "walk.bvh";
    file.file_bytes = WriteBvh({.frame_count = 20, .phase = 0.1 * clip_count_++});
    const auto stored = [&](const storage::ClipRecord& clip) {
      clips_.insert(clip.id);
      live_->lifecycle().RequestExtension();
      const auto operation = live_->lifecycle().Request();
      REQUIRE(operation.ok());
      Ask(*operation);
      return absl::OkStatus();
    };
    const auto clip =
        server::IngestClip(*store_, *live_, std::move(file), options_, core::Serially, {}, stored);
    INFO(clip.status().ToString());
    REQUIRE(clip.ok());
    last_ask_ = executor_.Now();
  }

  void Delete() {
    if (clips_.empty()) return;
    const auto clip = std::next(clips_.begin(), Below(static_cast<int>(clips_.size())));
    REQUIRE(store_->DeleteClip("db", *clip).ok());
    clips_.erase(clip);
    const auto operation = live_->lifecycle().Request();
    REQUIRE(operation.ok());
    Ask(*operation);
  }

  void Cancel() {
    if (asked_.empty()) return;
    const std::string& id =
        asked_[asked_.size() - 1 -
               static_cast<std::size_t>(Below(std::min<int>(2, std::ssize(asked_))))];
    const auto before = operations_.Get(id)->state;
    const auto is_first = live_->lifecycle().Cancel(id);
    REQUIRE(is_first.ok());
    if (*is_first) cancelled_.insert(id);
    if (before == OperationState::kPending) {
      CHECK(*is_first);
      CHECK(operations_.Get(id)->state == OperationState::kCancelled);
    }
  }

  // While a build is at work, on another thread. A timer does not fire: the build has its thread.
  void Meanwhile() {
    int running = 0;
    for (const std::string& id : asked_) {
      if (operations_.Get(id)->state != OperationState::kRunning) continue;
      ++running;
      if (begun_.insert(id).second) CheckBegin(id);
    }
    CHECK(running <= 1);
    switch (Below(200)) {
      case 0:
        return Ingest();
      case 1:
        return Delete();
      case 2:
        return Cancel();
      default:
        return;
    }
  }

  void CheckBegin(const std::string& id) {
    const auto latest = first_ask_.at(id) + options_.rebuild_delay_limit;
    const auto now = executor_.Now();
    CHECK((now >= latest || (in_flight_.empty() && now >= last_ask_ + options_.rebuild_delay)));
  }

  std::mt19937 random_;
  SimulatedExecutor executor_;
  server::EngineOptions options_;
  TemporaryDirectory directory_;
  const std::unique_ptr<storage::MotionStore> store_ =
      *storage::SqliteMotionStore::Open(directory_ / "store.db");
  server::OperationBook operations_{*store_};
  std::shared_ptr<server::LiveDatabase> live_;

  std::vector<std::unique_ptr<server::ModelLifecycle::Ingest>> in_flight_;
  std::set<std::string> clips_;
  int clip_count_ = 0;
  std::vector<std::string> asked_;  // operations, in order
  std::set<std::string> begun_;
  std::set<std::string> cancelled_;
  std::map<std::string, Executor::Clock::time_point> first_ask_;
  Executor::Clock::time_point last_ask_;
};

TEST_CASE("Lifecycle: keeps its promises whatever comes, and when", "[server][lifecycle]") {
  int builds = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    Simulation simulation(seed);
    for (int step = 0; step < 60; ++step) simulation.Step();
    simulation.CheckEnd();
    builds += simulation.builds();
    simulation.CheckStop();
  }
  CHECK(builds > 40);  // else the events were too dense for any
}

}  // namespace
}  // namespace motiondb::tests
