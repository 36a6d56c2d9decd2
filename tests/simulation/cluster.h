// The simulated servers of one store: they start, drain, crash, stop for a while, and lose the
// store.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "server/engine/engine.h"
#include "server/security/token_registry.h"
#include "tests/simulation/history.h"
#include "tests/simulation/simulated_store.h"
#include "tests/simulation/world.h"

namespace motiondb::simulation {

class Cluster {
 public:
  // All servers begin to start. `options`: of each server.
  Cluster(StoreServer& store, History& history, std::vector<server::EngineOptions> options);

  int size() const { return static_cast<int>(servers_.size()); }
  // Null: the server does not take calls.
  server::Engine* engine(int server) const;
  Process* process(int server) const { return servers_[server].process; }
  // The tokens of a server; null if it is ending.
  server::TokenRegistry* TokensOf(const server::Engine& engine) const;
  // Id of the life of a served database. Until the server notices that it was deleted, and created
  // again, calls by its name can mix both. 0: not known yet.
  std::int64_t LifeOf(int server, const server::LiveDatabase* database) const;

  // Kills a server. It starts again after a delay.
  void Crash(int server, Duration restart_delay);
  // Lets a server end orderly. It starts again after a delay.
  void Drain(int server, Duration restart_delay);
  // Ends all accidents. Servers that are down start soon.
  void Heal();
  // Ends all servers orderly. They do not start again.
  void Stop();
  bool all_are_up() const;
  bool all_are_down() const;

  // Checks what each server of a process serves, if it has changed. Called after each event.
  void CheckServed(const Process* process);

 private:
  struct Served {
    std::weak_ptr<server::LiveDatabase> database;
    std::int64_t life = 0;
    const storage::ModelRecord* record = nullptr;  // of the model, in memory or not
    std::int64_t revision = 0;
    int version = 0;  // the last stored one
  };
  struct Server {
    server::EngineOptions options;
    Process* process = nullptr;
    std::unique_ptr<server::TokenRegistry> tokens = {};
    std::unique_ptr<server::Engine> engine = {};
    bool is_ending = false;
    bool is_down = true;
    Duration restart_delay{};
    std::map<const server::LiveDatabase*, Served> served = {};
  };

  void Start(Server& server);
  // Runs in a task of the server.
  void Run(Server& server);
  void End(Server& server);

  StoreServer& store_;
  History& history_;
  std::vector<Server> servers_;
  std::vector<std::unique_ptr<Process>> processes_;  // also former ones
  bool is_stopping_ = false;
};

}  // namespace motiondb::simulation
