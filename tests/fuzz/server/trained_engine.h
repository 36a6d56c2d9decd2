// An engine with one database, "db", trained on a walk, a squat and a wave, for fuzzed queries.
// Created once per process; no socket.
#pragma once

#include <memory>
#include <utility>

#include "server/engine/query/query.h"

namespace motiondb::tests {

struct TrainedEngine {
  std::unique_ptr<server::Engine> engine;
  std::shared_ptr<server::LiveDatabase> database;
  std::shared_ptr<const server::Snapshot> snapshot;

  const core::Model& model() const { return snapshot->model; }
  // Returns a query that ends when `cancelled` returns true.
  server::Query Ask(core::Cancelled cancelled = {}) const {
    return *server::Query::Begin(*engine, "db", {.cancelled = std::move(cancelled)});
  }
};

TrainedEngine& Trained();

}  // namespace motiondb::tests
