// Simulation of the model lifecycle (server/engine/model_lifecycle.h): random changes of a
// database, also during builds, in simulated time, with crashes. Checks the guarantees of its
// states.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "server/engine/corruption_log.h"
#include "server/engine/ingest.h"
#include "server/engine/marker_schemes.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operation_registry.h"
#include "server/engine/snapshot.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/simulated_executor.h"
#include "tests/support/stick_figure.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::lifecycle_simulation_test {
namespace {

using server::Calibration;
using server::DeletionPolicy;
using server::Executor;
using std::chrono::milliseconds;
using storage::OperationState;

// Statistics of builds.
struct BuildStatistics {
  int builds = 0;
  int borrowing = 0;            // checks while an uncalibrated model answered
  int cancelled_borrowing = 0;  // builds cancelled at such a moment
  int extended_borrowing = 0;   // checks while such a model had clips ingested after its build

  BuildStatistics& operator+=(const BuildStatistics& more) {
    builds += more.builds;
    borrowing += more.borrowing;
    cancelled_borrowing += more.cancelled_borrowing;
    extended_borrowing += more.extended_borrowing;
    return *this;
  }
};

struct Crash {};

class Simulation {
 public:
  explicit Simulation(unsigned seed) : random_(seed), executor_(seed) {
    spdlog::set_level(spdlog::level::off);
    options_.rebuild_delay = milliseconds(300);
    options_.rebuild_delay_limit = milliseconds(2000);
    options_.extend_from = std::chrono::duration<double>(seed % 2 == 0 ? 0 : 3600);
    process_.emplace(directory_ / "store.db");
    REQUIRE(store()
                .CreateDatabase(
                    {.name = "db", .settings = kSettings, .marker_set = server::kSourceMarkerSet})
                .ok());
    Serve();
    executor_.between = [this] { Meanwhile(); };
  }

  // Runs one event: a clip, a deletion, a cancellation, a slow ingest that begins or ends, or time.
  void Step() {
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
        Change(event);
    }
  }

  // The server crashes, during the next build if possible, and another server opens its file.
  void CrashAndRestart() {
    Ingest();
    crash_in_ = 1 + Below(600);
    try {
      executor_.RunUntil(executor_.Now() + milliseconds(5000));
    } catch (const Crash&) {
    }
    crash_in_ = 0;
    in_flight_.clear();
    process_.reset();
    process_.emplace(directory_ / "store.db");
    for (const std::string& clip : clips_) CHECK(store().GetClip("db", clip).ok());
    Serve();
    previous_.reset();
    server::CorruptionLog corruptions;
    // The database is not visible meanwhile.
    const auto between = std::exchange(executor_.between, nullptr);
    lifecycle().LoadStored(corruptions);
    executor_.between = between;
    CHECK(corruptions.List().empty());
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

  // Checks that all operations end and that the model has exactly the stored clips.
  void CheckEnd() {
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
    const auto snapshot = lifecycle().snapshot();
    REQUIRE(snapshot != nullptr);
    CHECK(snapshot->is_stored());
    CHECK(KnownTo(*snapshot) == clips_);
    CheckServed();
  }

  // Checks that after BeginStop nothing starts and a waiting operation stays PENDING.
  void CheckStop() {
    Ingest();
    const std::string waiting = requested_.back();
    lifecycle().BeginStop();
    executor_.RunUntil(executor_.Now() + std::chrono::hours(1));
    lifecycle().AwaitStop();
    CHECK(operations().Get(waiting)->state == OperationState::kPending);
  }

  // Checks that a build stopped by the drain is PENDING and the model keeps answering. Returns
  // false if no build ran for long enough.
  bool CheckDrainInBuild() {
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

  // Checks that a database deleted during a build has no model, then and later.
  bool CheckDeletionInBuild() {
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

  const BuildStatistics& statistics() const { return statistics_; }

 private:
  static constexpr core::BuildSettings kSettings{.frame_rate_hz = 60, .min_frames = 4};

  // State of one server process.
  struct Process {
    explicit Process(const std::string& path)
        : store(*storage::SqliteMotionStore::Open(path)), operations(*store) {}
    const std::unique_ptr<storage::MotionStore> store;
    server::OperationRegistry operations;
    std::shared_ptr<server::LiveDatabase> live;
  };

  storage::MotionStore& store() { return *process_->store; }
  server::OperationRegistry& operations() { return process_->operations; }
  server::ModelLifecycle& lifecycle() { return process_->live->lifecycle(); }

  void Serve() {
    auto live = std::make_shared<server::LiveDatabase>("db", kSettings);
    live->Serve(std::make_unique<server::ModelLifecycle>(
        *live, server::LifecycleServices{store(), operations(), executor_, options_}));
    const auto record = store().GetDatabase("db");
    REQUIRE(record.ok());
    server::MarkerSchemes schemes;
    live->set_scheme(schemes.Of(*record));
    process_->live = std::move(live);
  }

  // Runs the next build and calls `event` at random moments of it until it returns true. Returns
  // whether it did.
  bool InBuild(const std::function<bool()>& event) {
    int steps_left = 1 + Below(150);
    bool happened = false;
    executor_.between = [&] {
      if (--steps_left <= 0 && !happened) happened = event();
    };
    executor_.RunUntil(executor_.Now() + std::chrono::hours(1));
    executor_.between = nullptr;
    return happened;
  }

  int Below(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }

  std::unique_ptr<server::ModelLifecycle::Ingest> NewIngest() {
    return std::make_unique<server::ModelLifecycle::Ingest>(process_->live);
  }

  void Ask(const storage::OperationRecord& operation) {
    CHECK(operation.state == OperationState::kPending);
    // An operation that waits since a restart is joined again after later ones were cancelled.
    if (std::ranges::find(requested_, operation.id) == requested_.end()) {
      requested_.push_back(operation.id);
      first_request_[operation.id] = executor_.Now();
    }
    last_request_ = executor_.Now();
  }

  void Ingest() {
    const auto in_flight = NewIngest();
    storage::NewClip clip;
    clip.record.file_name = "walk.bvh";
    clip.id_is_fixed = true;
    clip.record.id = "walk" + std::to_string(clip_count_);
    clip.file_bytes = WriteBvh({.frame_count = 20, .phase = 0.1 * clip_count_++});
    const auto stored = [&](const storage::ClipRecord& record) {
      clips_.insert(record.id);
      lifecycle().RequestExtension();
      const auto operation = lifecycle().Request();
      REQUIRE(operation.ok());
      Ask(*operation);
      return absl::OkStatus();
    };
    const auto ingested = server::IngestClip(store(), *process_->live, std::move(clip), options_,
                                             core::RunSerially, {}, stored);
    INFO(ingested.status().ToString());
    REQUIRE(ingested.ok());
    last_request_ = executor_.Now();
  }

  void Delete() {
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

  void Cancel() {
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

  // Runs between the steps of a build, as another thread would. Timers do not fire: the build uses
  // their thread.
  void Meanwhile() {
    if (crash_in_ > 0 && --crash_in_ == 0) throw Crash();
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

  // Changes that may also come during a build; none for most events.
  void Change(int event) {
    if (event == 0) Ingest();
    if (event == 1) Delete();
    if (event == 2) Cancel();
  }

  void CheckBegin(const std::string& id) {
    const auto latest = first_request_.at(id) + options_.rebuild_delay_limit;
    const auto now = executor_.Now();
    CHECK((now >= latest || (in_flight_.empty() && now >= last_request_ + options_.rebuild_delay)));
  }

  static std::set<std::string> KnownTo(const server::Snapshot& snapshot) {
    std::set<std::string> known;
    for (const auto& clip : snapshot.model.clips()) known.insert(clip.id);
    return known;
  }

  // Checks the current model against the previous one.
  void CheckServed() {
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

  // Checks that a reported version is that of a stored model, and of the current one if the
  // snapshot is stored.
  void CheckVersion(const server::Snapshot& snapshot) {
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

  std::mt19937 random_;
  SimulatedExecutor executor_;
  server::EngineOptions options_;
  TemporaryDirectory directory_;
  std::optional<Process> process_;

  std::vector<std::unique_ptr<server::ModelLifecycle::Ingest>> in_flight_;
  std::set<std::string> clips_;
  int clip_count_ = 0;
  std::vector<std::string> requested_;  // operation ids, in order
  std::set<std::string> started_;
  std::set<std::string> cancelled_;
  std::map<std::string, Executor::Clock::time_point> first_request_;
  Executor::Clock::time_point last_request_;
  int crash_in_ = 0;  // steps of builds until the crash; 0: never

  std::shared_ptr<const server::Snapshot> previous_;  // at the last CheckServed
  core::RecognitionCalibration last_own_;
  bool is_emptied_since_ = false;  // all clips were deleted since the current model
  bool is_deleted_since_ = false;  // a clip was deleted since the current model
  BuildStatistics statistics_;
};

TEST_CASE("Lifecycle: keeps its guarantees under random events", "[server][lifecycle]") {
  BuildStatistics statistics;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    CAPTURE(seed);
    Simulation simulation(seed);
    for (int step = 0; step < 60; ++step) simulation.Step();
    simulation.CheckEnd();
    statistics += simulation.statistics();
    simulation.CheckStop();
  }
  // Otherwise the events were too dense or too rare to test these cases.
  CHECK(statistics.builds > 40);
  CHECK(statistics.borrowing > 100);
  CHECK(statistics.cancelled_borrowing > 0);
  CHECK(statistics.extended_borrowing > 0);
}

TEST_CASE("Lifecycle: a crash at any moment loses no acknowledged change", "[server][lifecycle]") {
  BuildStatistics statistics;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    Simulation simulation(seed);
    for (int life = 0; life < 3; ++life) {
      for (int step = 0; step < 15; ++step) simulation.Step();
      simulation.CrashAndRestart();
    }
    simulation.CheckEnd();
    statistics += simulation.statistics();
  }
  CHECK(statistics.borrowing > 100);
}

TEST_CASE("Lifecycle: can drain or be deleted at any moment of a build", "[server][lifecycle]") {
  int drains = 0;
  int deletions = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    CAPTURE(seed);
    Simulation drained(seed);
    for (int step = 0; step < 10; ++step) drained.Step();
    drained.CheckEnd();
    drains += drained.CheckDrainInBuild();
    Simulation deleted(seed);
    for (int step = 0; step < 10; ++step) deleted.Step();
    deleted.CheckEnd();
    deletions += deleted.CheckDeletionInBuild();
  }
  CHECK(drains > 5);
  CHECK(deletions > 5);
}

}  // namespace
}  // namespace motiondb::tests::lifecycle_simulation_test
