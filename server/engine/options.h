// What an operator can set about the engine.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace motiondb::server {

// The most that one database may hold. Served, a frame of 34 markers takes 1.2 KB of memory.
struct DatabaseQuota {
  int clip_count = 100'000;
  int frame_count = 5'000'000;
  std::int64_t byte_count = std::int64_t{64} << 30;  // of the blobs of its clips
};

struct EngineOptions {
  int query_threads = 0;  // 0: as many as the machine has
  int heavy_threads = 0;  // of these, for long work such as plans; 0: all but one
  int build_threads = 0;  // 0: half as many, so that queries keep a core
  // A rebuild starts when no ingest has come for `rebuild_delay`, at the latest
  // `rebuild_delay_limit` after it was asked for: a burst of ingests costs one.
  std::chrono::milliseconds rebuild_delay{300};
  std::chrono::milliseconds rebuild_delay_limit{10'000};
  // After one that failed for want of room, or of a disk, the next is asked for.
  std::chrono::milliseconds rebuild_retry_delay{60'000};
  // A model that took at least so long to build is extended by new clips at once, and built again
  // when it has drifted; others are simply built again.
  std::chrono::duration<double> extend_from{0.5};
  std::size_t max_file_bytes = std::size_t{64} << 20;  // of a motion file with its skeleton
  // Of a clip or observation, at its own rate, and at the database's; of 34 markers, of more as
  // many fewer. More than an hour at 60 Hz.
  int max_frames = 250'000;
  std::size_t max_databases = 1000;
  DatabaseQuota quota;
};

}  // namespace motiondb::server
