// An engine with one database, "db", that knows a walk, a squat and a wave: what fuzzed queries are
// put to. Made once a process; no socket.
#pragma once

#include <memory>

#include "server/engine/engine.h"
#include "server/engine/snapshot.h"

namespace motiondb::tests {

struct TrainedEngine {
  std::unique_ptr<server::Engine> engine;
  std::shared_ptr<server::LiveDatabase> database;
  std::shared_ptr<const server::Snapshot> snapshot;

  const core::Model& model() const { return snapshot->model; }
};

TrainedEngine& Trained();

}  // namespace motiondb::tests
