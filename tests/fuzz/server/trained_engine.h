// An engine with one database, "db", that knows a walk, a squat and a wave: what fuzzed queries are
// put to. Made once a process; no socket.
#pragma once

#include <memory>
#include <utility>

#include "server/engine/query.h"

namespace motiondb::tests {

struct TrainedEngine {
  std::unique_ptr<server::Engine> engine;
  std::shared_ptr<server::LiveDatabase> database;
  std::shared_ptr<const server::Snapshot> snapshot;

  const core::Model& model() const { return snapshot->model; }
  // One that ends when `cancelled` says so.
  server::Query Ask(core::Cancelled cancelled = {}) const {
    return *server::Query::Begin(*engine, "db", {.cancelled = std::move(cancelled)});
  }
};

TrainedEngine& Trained();

}  // namespace motiondb::tests
