// The simulated clients: each sends one call after another to any server, over a network that loses
// calls and answers, and checks the answers.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/engine/engine.h"
#include "tests/simulation/cluster.h"
#include "tests/simulation/history.h"
#include "tests/simulation/world.h"

namespace motiondb::simulation {

class Clients {
 public:
  Clients(Cluster& cluster, History& history);

  // Starts a client, which sends calls until Stop.
  void Start(int client);
  void Stop() { is_stopping_ = true; }
  bool all_have_ended() const { return running_ == 0; }
  // From now on, the answers of all servers must have each model this long after it was stored.
  void set_max_model_delay(Duration delay) { max_model_delay_ = delay; }
  // Adds one more clip to a database, in a task. Tries until it is acknowledged.
  void AddLastClip(const std::string& database);
  // Asks a server for the model of a database with all clips, in a task. Fails if it does not come
  // soon. `life`: until the task ends.
  void AskForLastModel(int server, const DatabaseLife& life);
  // Revokes a token, in a task. Fails if a server then accepts a revoked one for too long.
  void RevokeLastToken();
  // Checks that all operations have ended as the clients were told.
  void CheckOperations();

 private:
  struct Request {
    server::Engine& engine;
    const core::Cancelled& cancelled;
  };
  template <typename Result>
  using Work = std::function<absl::StatusOr<Result>(const Request&)>;
  struct KnownOperation {
    std::int64_t life = 0;                          // of its database
    std::optional<storage::OperationState> result;  // that a client was told
  };

  struct KnownToken {
    std::string id;
    std::string text;
    bool may_be_revoked = false;
    const Process* revoked_by = nullptr;  // the last one that has stored it
  };

  // Sends a call to a server. DEADLINE_EXCEEDED: its result is unknown.
  template <typename Result>
  absl::StatusOr<Result> Call(int server, server::Pool pool, Work<Result> work);
  // Runs a change of a database on a server, and notes whether its operation was requested.
  template <typename Result>
  absl::StatusOr<Result> Change(int server, const std::string& database, Work<Result> work);
  // Returns the result of `find`. Fails if it is NOT_FOUND and the database existed all the time.
  template <typename Function>
  auto Find(const std::string& database, const Function& find);
  absl::StatusOr<std::shared_ptr<server::LiveDatabase>> FindDatabase(server::Engine& engine,
                                                                     const std::string& database);
  int AnyServer() const;

  void Step(int client);
  absl::Status Create(const std::string& database);
  absl::Status Delete(const std::string& database);
  absl::Status Ingest(const std::string& database, int motion, const std::string& clip);
  absl::Status DeleteClip(const std::string& database, const std::string& clip);
  absl::Status SetLabel(const std::string& database, const std::string& clip);
  absl::Status Reprocess(const std::string& database);
  absl::Status List(const std::string& database);
  absl::Status AskForModel(const std::string& database);
  // Asks all servers for a model when they look at the store next, in tasks.
  void AskAtNextLook(const DatabaseLife& life);
  // Asks all servers for the newest model after max_model_delay_, in tasks.
  void AskAfterDelay(const DatabaseLife& life);
  absl::Status Cancel();
  absl::Status GetOperation();
  absl::Status WaitForOperation();
  absl::Status MakeToken();
  absl::Status RevokeToken(int server);
  absl::Status UseAnyToken();
  // `is_revoked`: the server must know that.
  absl::Status UseToken(int server, const KnownToken& token, bool is_revoked);

  // A client was told of an operation.
  void NoteOperation(const storage::OperationRecord& operation);
  std::string AnyOperation() const;  // empty: none is known

  Cluster& cluster_;
  History& history_;
  bool is_stopping_ = false;
  Duration max_model_delay_{};  // 0: none
  int running_ = 0;
  int label_count_ = 0;
  std::map<std::string, KnownOperation> operations_;
  std::deque<KnownToken> tokens_;
};

}  // namespace motiondb::simulation
