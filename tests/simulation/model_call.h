// A call of a client that needs the model of a database, which the server may have to read first.
// Like all such calls it runs again on a thread of the server after each change that it waits for.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/engine/change_signal.h"
#include "server/engine/engine.h"
#include "tests/simulation/cluster.h"
#include "tests/simulation/history.h"
#include "tests/simulation/world.h"

namespace motiondb::simulation {

class ModelCall : public std::enable_shared_from_this<ModelCall> {
 public:
  ModelCall(Cluster& cluster, History& history, int server, std::string database)
      : cluster_(cluster),
        history_(history),
        server_(server),
        engine_(cluster.engine(server)),
        process_(cluster.process(server)),
        database_(std::move(database)) {}

  // Returns the model, with the changes up to a revision (0: any). Fails if it is not one that the
  // server may serve. DEADLINE_EXCEEDED at `end`; UNAVAILABLE if the server ends. Called once.
  absl::StatusOr<server::ServedModel> Send(std::int64_t min_revision, Time end);

 private:
  bool server_runs() const {
    return cluster_.process(server_) == process_ && cluster_.engine(server_) == engine_ &&
           engine_ != nullptr;
  }
  void Post();
  // On a thread of the server.
  void Run();
  absl::StatusOr<server::ServedModel> Try();
  void WakeOn(server::ChangeSignal& signal);
  void OnChange();

  Cluster& cluster_;
  History& history_;
  const int server_;
  server::Engine* const engine_;
  Process* const process_;
  const std::string database_;
  std::int64_t min_revision_ = 0;
  bool has_changed_ = false;  // since the last run began
  bool is_parked_ = false;    // until the next change
  bool has_result_ = false;
  absl::StatusOr<server::ServedModel> result_ = absl::DeadlineExceededError("no answer");
  WaitList waiting_;
  std::map<server::ChangeSignal*, std::unique_ptr<server::ChangeSignal::Subscription>>
      subscriptions_;
};

}  // namespace motiondb::simulation
