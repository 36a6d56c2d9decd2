// What the store of a simulation contained after each change, and the invariants of changes and
// answers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/engine/snapshot.h"
#include "tests/simulation/simulated_store.h"

namespace motiondb::simulation {

struct StoredClip {
  std::int64_t create_time_us = 0;  // identifies it
  int frame_count = 0;
  std::string label;

  bool operator==(const StoredClip&) const = default;
};
using StoredClips = std::map<std::string, StoredClip>;  // by id

struct StoredModel {
  std::int64_t create_time_us = 0;
  int frame_count = 0;
  std::vector<std::string> clips;
  std::vector<int> nodes_per_layer;
  std::size_t states_hash = 0;

  bool operator==(const StoredModel&) const = default;
};

// One life of a database. One that is created again under its name has another.
struct DatabaseLife {
  struct Content {
    std::int64_t revision = 0;
    StoredClips clips;
  };

  std::int64_t id = 0;
  std::string name;
  bool is_deleted = false;
  std::vector<Content> contents = {{}};  // after each change of clips, in order
  std::map<int, StoredModel> models;     // by version
  int current_model = 0;                 // 0: none
  std::int64_t model_revision = 0;       // of the database, after the last model
  // The last time at which an operation was cancelled or has failed; none since a later change. The
  // model then waits for the next change.
  std::optional<Time> incomplete;

  const StoredClips& clips() const { return contents.back().clips; }
  // The contents from a revision on.
  std::vector<const StoredClips*> Since(std::int64_t revision) const;
};

class History {
 public:
  explicit History(StoreServer& server);

  // The life of a database that exists, or null.
  DatabaseLife* Find(const std::string& name);
  // The life that had this clip, or null.
  DatabaseLife* FindByClip(const std::string& name, std::int64_t clip_create_time_us);
  const std::map<std::int64_t, DatabaseLife>& lives() const { return lives_; }
  // Id of the life in which an operation was stored first; 0: it was not stored.
  std::int64_t LifeOfOperation(const std::string& operation) const;

  // Checks what a server serves for a life of a database. `what`: for the message. Returns false if
  // it is of a later life with the same name, or the life has ended.
  bool CheckServed(const std::string& what, std::int64_t life, const server::ServedModel& served);
  // Checks that the clips of a list, which contains the changes up to a revision, are right.
  void CheckListed(const std::string& what, const DatabaseLife& life, std::int64_t revision,
                   const std::map<std::string, std::string>& labels) const;

  // Checks that the content of deleted databases is gone.
  void CheckIsFreed();

  // Called after a model was stored, before anything else runs.
  void set_on_model(std::function<void(const DatabaseLife&)> on_model) {
    on_model_ = std::move(on_model);
  }
  SimulatedStore& store() { return store_; }

 private:
  void OnChange(const StoreCall& call);
  void NoteOperation(const StoreCall& call);
  void ReadContents();
  void ReadModel(const StoreCall& call, DatabaseLife& life);
  // Checks that a model was stored with the newest lease, in place of the one its builder had seen.
  void CheckTerms(const StoreCall& call, const DatabaseLife& life, int replaced);
  // The life whose stored model has this record. Fails if there is none.
  const DatabaseLife& LifeOf(const std::string& what, const std::string& database,
                             const storage::ModelRecord& record) const;
  std::int64_t LastFence(const DatabaseLife& life);

  StoreServer& server_;
  SimulatedStore store_;                        // for reads
  std::map<std::int64_t, DatabaseLife> lives_;  // by id
  std::map<std::string, std::int64_t> operation_lives_;
  std::function<void(const DatabaseLife&)> on_model_;
};

}  // namespace motiondb::simulation
