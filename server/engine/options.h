// What an operator can set about the engine.
#pragma once

#include <chrono>
#include <cstddef>

namespace motiondb::server {

struct EngineOptions {
  int query_threads = 0;  // 0: as many as the machine has
  int build_threads = 0;  // 0: half as many, so that queries keep a core
  // A rebuild starts when no ingest has come for `rebuild_delay`, at the latest
  // `rebuild_delay_limit` after it was asked for: a burst of ingests costs one.
  std::chrono::milliseconds rebuild_delay{300};
  std::chrono::milliseconds rebuild_delay_limit{10'000};
  // A model that took at least so long to build is extended by new clips at once, and built again
  // when it has drifted; others are simply built again.
  std::chrono::duration<double> extend_from{0.5};
  std::size_t max_file_bytes = std::size_t{64} << 20;  // of a motion file with its skeleton
  int max_frames = 1'000'000;  // of a clip or an observation, at the database's frame rate
};

}  // namespace motiondb::server
