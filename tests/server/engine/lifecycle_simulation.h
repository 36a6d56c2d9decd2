// Simulation of the model lifecycle (server/engine/model_lifecycle.h): random changes of a
// database, also during builds, in simulated time, with crashes. Checks the guarantees of its
// states.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operator_log.h"
#include "server/engine/snapshot.h"
#include "server/engine/work/operation_registry.h"
#include "storage/motion_store.h"
#include "tests/support/simulated_executor.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {

// Statistics of builds.
struct BuildStatistics {
  int builds = 0;
  int borrowing = 0;            // checks while an uncalibrated model answered
  int cancelled_borrowing = 0;  // builds cancelled at such a moment
  int extended_borrowing = 0;   // checks while such a model had clips ingested after its build
  int evictions = 0;

  BuildStatistics& operator+=(const BuildStatistics& more) {
    builds += more.builds;
    borrowing += more.borrowing;
    cancelled_borrowing += more.cancelled_borrowing;
    extended_borrowing += more.extended_borrowing;
    evictions += more.evictions;
    return *this;
  }
};

class LifecycleSimulation {
 public:
  explicit LifecycleSimulation(unsigned seed);

  // Runs one event: a clip, a deletion, a cancellation, a slow ingest that begins or ends, or time.
  void Step();

  // The server crashes, during the next build if possible, and another server opens its file.
  void CrashAndRestart();

  // Checks that all operations end and that the model has exactly the stored clips.
  void CheckEnd();

  // Checks that after BeginStop nothing starts and a waiting operation stays PENDING.
  void CheckStop();

  // Checks that a build stopped by the drain is PENDING and the model keeps answering. Returns
  // false if no build ran for long enough.
  bool CheckDrainInBuild();

  // Checks that a database deleted during a build has no model, then and later.
  bool CheckDeletionInBuild();

  const BuildStatistics& statistics() const { return statistics_; }

 private:
  // State of one server process.
  struct Process {
    explicit Process(const std::string& path);
    const std::unique_ptr<storage::MotionStore> store;
    server::OperationRegistry operations;
    std::shared_ptr<server::LiveDatabase> live;
  };

  storage::MotionStore& store() { return *process_->store; }
  server::OperationRegistry& operations() { return process_->operations; }
  server::ModelLifecycle& lifecycle() { return process_->live->lifecycle(); }

  int Below(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
  std::unique_ptr<server::ModelLifecycle::Ingest> NewIngest() {
    return std::make_unique<server::ModelLifecycle::Ingest>(process_->live);
  }

  // Serves the database of the current process, without a model.
  void Serve();
  // Runs the next build and calls `event` at random moments of it until it returns true. Returns
  // whether it did.
  bool InBuild(const std::function<bool()>& event);
  // Notes that `operation` was requested now.
  void Ask(const storage::OperationRecord& operation);
  void Ingest();
  void Delete();
  void Cancel();
  // Runs between the steps of a build, as another thread would. Timers do not fire: the build uses
  // their thread.
  void Meanwhile();
  // Changes that may also come during a build; none for most events.
  void Change(int event);
  void CheckBegin(const std::string& id);
  // Checks the current model against the previous one.
  void CheckServed();
  // Checks that a reported version is that of a stored model, and of the current one if the
  // snapshot is stored.
  void CheckVersion(const server::Snapshot& snapshot);

  std::mt19937 random_;
  server::CorruptionLog corruptions_;
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
  std::map<std::string, server::Executor::Clock::time_point> first_request_;
  server::Executor::Clock::time_point last_request_;
  int crash_in_ = 0;  // steps of builds until the crash; 0: never

  std::shared_ptr<const server::Snapshot> previous_;  // at the last CheckServed
  core::RecognitionCalibration last_own_;
  bool is_emptied_since_ = false;  // all clips were deleted since the current model
  bool is_deleted_since_ = false;  // a clip was deleted since the current model
  BuildStatistics statistics_;
};

}  // namespace motiondb::tests
