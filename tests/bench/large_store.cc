#include "tests/bench/large_store.h"

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <string_view>
#include <utility>

#include "core/format/marker_set_file.h"
#include "core/motion/error.h"
#include "server/engine/clock.h"
#include "server/engine/content_hash.h"
#include "server/engine/marker_schemes.h"
#include "server/engine/rebuild.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/real_data.h"

namespace motiondb::tests {
namespace {

// Times the stages that a build tells of. "tree, layer 7" is of the stage "tree".
class StageLog {
 public:
  void Enter(std::string_view told) {
    const std::string_view name = told.substr(0, told.find(','));
    if (!stages_.empty() && stages_.back().name == name) return;
    Leave();
    stages_.push_back({std::string(name), 0, 0});
    entered_ = std::chrono::steady_clock::now();
  }
  void Leave() {
    if (stages_.empty()) return;
    const auto now = std::chrono::steady_clock::now();
    stages_.back().seconds = std::chrono::duration<double>(now - entered_).count();
    stages_.back().peak_mb = ProcessMegabytes("VmHWM");
  }
  std::vector<BuildStage> stages() && { return std::move(stages_); }

 private:
  std::vector<BuildStage> stages_;
  std::chrono::steady_clock::time_point entered_;
};

}  // namespace

absl::Status AddClips(storage::MotionStore& store, std::vector<core::BuildInput> inputs) {
  for (core::BuildInput& input : inputs) {
    storage::NewClip clip;
    clip.file_bytes = fmt::format("{}: {}\n", input.clip_id, kVariedMotion);
    clip.record = {.database = kLargeDatabase,
                   .id = input.clip_id,
                   .label = input.label,
                   .subject = input.subject,
                   .file_name = input.clip_id + ".bvh",
                   .frame_count = input.states.frame_count(),
                   .duration_seconds = input.states.frame_count() / input.states.frame_rate_hz,
                   .source_frame_rate_hz = input.states.frame_rate_hz,
                   .leg_length_m = input.states.leg_length_m,
                   .source_report = kVariedMotion,
                   .content_hash = server::ContentHash(clip.file_bytes, ""),
                   .create_time_us = server::NowMicroseconds()};
    clip.states = std::move(input.states);
    MOTIONDB_RETURN_IF_ERROR(store.AddClip(clip).status());
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<BuildStage>> MakeLargeStore(const std::string& path,
                                                       const VariedSize& size, std::uint64_t seed,
                                                       const core::ParallelFor& parallel) {
  storage::DatabaseRecord record{
      .name = kLargeDatabase,
      .marker_set = server::kStandardMarkerSet,
      .marker_set_text = core::WriteMarkerSetFile(core::StandardScheme()),
      .create_time_us = server::NowMicroseconds()};
  record.settings.frame_rate_hz = size.frame_rate_hz;
  MOTIONDB_ASSIGN_OR_RETURN(const auto store, storage::SqliteMotionStore::Open(path));
  MOTIONDB_RETURN_IF_ERROR(store->CreateDatabase(record));
  StageLog log;
  log.Enter("generating clips");
  MOTIONDB_ASSIGN_OR_RETURN(auto clips, VariedClips(DataDir(), size, seed, parallel));
  log.Enter("adding clips");
  MOTIONDB_RETURN_IF_ERROR(AddClips(*store, std::move(clips)));

  server::LiveDatabase live(record.name, record.settings);
  live.set_scheme(server::StoredScheme(record));
  const auto progress = [&](double, std::string_view stage) {
    log.Enter(stage);
    return true;
  };
  const auto stopped = [] { return false; };
  MOTIONDB_RETURN_IF_ERROR(server::Rebuild(*store, live, {}, parallel, progress, stopped).status());
  log.Leave();
  return std::move(log).stages();
}

double ProcessMegabytes(const std::string& field) {
  std::ifstream status("/proc/self/status");
  std::string name;
  for (double kilobytes = 0; status >> name;) {
    if (name == field + ":" && status >> kilobytes) return 1024 * kilobytes / 1e6;
  }
  return 0;
}

}  // namespace motiondb::tests
