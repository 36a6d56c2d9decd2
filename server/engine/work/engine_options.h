// Engine settings of the operator.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <thread>

namespace motiondb::server {

// Limits of one database. A served frame of 34 markers takes 1.2 KB of memory.
struct DatabaseQuota {
  int clip_count = 100'000;
  int frame_count = 5'000'000;
  std::int64_t byte_count = std::int64_t{64} << 30;  // of the blobs of all clips
};

// What a server does, if several servers share a store. One of a file does both.
enum class ServerWork {
  kBoth,
  kServe,  // builds no models
  kBuild,  // keeps only the model in memory that it built last, unless model_memory_bytes is set
};

struct EngineOptions {
  int query_threads = 0;  // 0: number of hardware threads
  int build_threads = 0;  // 0: half of them, so that queries keep a core
  // A rebuild starts when no ingest has come for `rebuild_delay`, but at most `rebuild_delay_limit`
  // after it was requested: a burst of ingests costs one rebuild.
  std::chrono::milliseconds rebuild_delay{300};
  std::chrono::milliseconds rebuild_delay_limit{10'000};
  // Delay before a rebuild is requested again after one that failed because of low memory or disk
  // space.
  std::chrono::milliseconds rebuild_retry_delay{60'000};
  // A model whose build took at least this long is extended by new clips immediately and rebuilt
  // when it has drifted. Other models are rebuilt for each change.
  std::chrono::duration<double> extend_from{0.5};
  std::size_t max_file_bytes = std::size_t{64} << 20;  // of a motion file and its skeleton file
  // Maximum frames of a clip or observation, at its own rate and at the database's, for 34 markers;
  // proportionally fewer for more markers. More than an hour at 60 Hz.
  int max_frames = 250'000;
  std::size_t max_databases = 1000;
  ServerWork work = ServerWork::kBoth;
  // Memory for models; 0: no limit. With a limit, a model is read when it is first used, and the
  // models that were not used for the longest time are evicted. The last used model always stays.
  std::int64_t model_memory_bytes = 0;
  DatabaseQuota quota;

  bool builds() const { return work != ServerWork::kServe; }
};

// Returns the maximum number of imports of this process at a time: one for every two processors,
// one to four. Others wait.
inline int MaxImports() {
  constexpr int kMaxImports = 4;
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()) / 2, 1, kMaxImports);
}

}  // namespace motiondb::server
