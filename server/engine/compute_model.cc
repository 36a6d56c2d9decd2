#include "server/engine/compute_model.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/calibration/model_difference.h"
#include "core/motion/error.h"
#include "server/engine/work/clock.h"
#include "storage/blob/newer_format.h"
#include "storage/clip_segments.h"

namespace motiondb::server {
namespace {

constexpr double kReadShare = 1.0 / 6;  // share of reading in the time of reading and building

}  // namespace

absl::StatusOr<core::Model> ModelOfClips(storage::MotionStore& store, LiveDatabase& database,
                                         const std::vector<storage::ClipRecord>& clips,
                                         const core::ParallelFor& parallel,
                                         const core::BuildProgress& progress) {
  std::vector<std::string> ids;
  ids.reserve(clips.size());
  for (const storage::ClipRecord& clip : clips) ids.push_back(clip.id);
  const auto read_progress = [&](std::size_t read) {
    const double share = static_cast<double>(read) / static_cast<double>(ids.size());
    return progress(kReadShare * share, "reading clips");
  };
  MOTIONDB_ASSIGN_OR_RETURN(auto inputs, ReadInputs(store, database, ids, parallel, read_progress));
  if (inputs.empty()) {
    const auto unreadable = database.unreadable();
    if (unreadable.empty()) return absl::AbortedError("all clips were deleted meanwhile");
    return core::DataLoss("database '{}': no clip can be read, all are corrupt: {}",
                          database.name(), unreadable.begin()->second);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, database.scheme());
  if (scheme == nullptr) return UnknownMarkers(store, database.name());
  const auto build_progress = [&](double fraction, std::string_view stage) {
    return progress(kReadShare + (1 - kReadShare) * fraction, stage);
  };
  return core::BuildModel(database.settings(), scheme->set, std::move(inputs), parallel,
                          build_progress);
}

absl::StatusOr<std::optional<ExtendedModel>> ModelWithClips(storage::MotionStore& store,
                                                            LiveDatabase& database,
                                                            const core::Model& base,
                                                            const std::vector<std::string>& clips,
                                                            const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(auto inputs, ReadInputs(store, database, clips, parallel));
  if (inputs.empty()) return std::nullopt;
  MOTIONDB_ASSIGN_OR_RETURN(core::Model model,
                            core::ExtendModel(base, std::move(inputs), parallel));
  const core::ModelDrift drift = core::MeasureDrift(model, parallel);
  return ExtendedModel{std::move(model), drift};
}

storage::ModelRecord ModelRecordOf(const std::string& database, int version,
                                   const core::Model& model, double drift_fraction) {
  storage::ModelRecord record;
  record.database = database;
  record.version = version;
  record.current = true;
  record.create_time_us = NowMicroseconds();
  record.build_seconds = model.build_seconds();
  record.frame_count = model.frame_count();
  record.clip_count = static_cast<std::int32_t>(model.clips().size());
  record.dimension_count = model.marker_set().dimension_count();
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    record.nodes_per_layer.push_back(model.tree().node_count(layer));
  }
  record.added_clip_count = record.clip_count - model.built_clip_count();
  record.added_frame_count = record.frame_count - model.built_frame_count();
  record.drift_fraction = drift_fraction;
  return record;
}

bool HasDrifted(const storage::ModelRecord& record) {
  const double added = static_cast<double>(record.added_frame_count) / record.frame_count;
  return core::ModelDrift{added, record.drift_fraction}.IsLarge();
}

std::string DifferenceText(const Snapshot* before, const core::Model& built,
                           const core::ParallelFor& parallel) {
  if (before == nullptr || before->record.added_clip_count == 0) return "";
  const core::ModelDifference difference = core::CompareModels(before->model, built, parallel);
  return fmt::format(
      "replaced extended model with {} added clips: bottom nodes {} -> {}, rms distance of frames "
      "from their node's mean {:.4f} -> {:.4f}, same label for {} of {} left-out windows",
      before->record.added_clip_count, difference.bottom_nodes_before,
      difference.bottom_nodes_after, difference.spread_before, difference.spread_after,
      difference.same_label, difference.windows);
}

namespace {

constexpr std::size_t kClipsAtOnce = 16;

absl::StatusOr<core::BuildInput> ReadInput(storage::MotionStore& store, const std::string& database,
                                           const Catalog& catalog, const std::string& clip) {
  const CatalogClip* const stored = catalog.Find(clip);
  if (stored == nullptr) return core::NotFound("clip '{}' was deleted", clip);
  MOTIONDB_ASSIGN_OR_RETURN(auto states, store.ReadClipStates(database, clip));
  auto labels =
      storage::LabelTracksOf(stored->segments, states.frame_rate_hz, states.frame_count());
  return core::BuildInput{clip, std::move(labels), std::move(states), stored->subject};
}

}  // namespace

absl::StatusOr<std::vector<storage::ClipRecord>> AllClips(storage::MotionStore& store,
                                                          const std::string& database) {
  storage::Page page{.after = "", .limit = 1000};
  std::vector<storage::ClipRecord> clips;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(auto next, store.ListClips(database, page));
    const bool last = static_cast<int>(next.size()) < page.limit;
    std::ranges::move(next, std::back_inserter(clips));
    if (last) return clips;
    page.after = clips.back().id;
  }
}

absl::Status CheckNoneIsNewer(const std::vector<storage::ClipRecord>& clips) {
  const auto newer = std::ranges::find_if(clips, [](const storage::ClipRecord& clip) {
    return clip.representation_version > core::kRepresentationVersion;
  });
  if (newer == clips.end()) return absl::OkStatus();
  return storage::NewerFormat(fmt::format("clip '{}'", newer->id));
}

absl::Status UnknownMarkers(storage::MotionStore& store, const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, store.GetDatabase(database));
  if (record.marker_set_text.empty()) {
    return absl::InternalError(fmt::format("database '{}' has clips but no markers", database));
  }
  return absl::UnavailableError(
      fmt::format("the markers of database '{}' are not known yet", database));
}

absl::StatusOr<std::vector<core::BuildInput>> ReadInputs(
    storage::MotionStore& store, LiveDatabase& database, const std::vector<std::string>& clips,
    const core::ParallelFor& parallel, const std::function<bool(std::size_t)>& go_on) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto catalog, database.Catalog(store.annotations()));
  std::vector<core::BuildInput> inputs;
  inputs.reserve(clips.size());
  for (std::size_t first = 0; first < clips.size(); first += kClipsAtOnce) {
    if (go_on && !go_on(first)) return absl::CancelledError("stopped");
    const std::size_t count = std::min(kClipsAtOnce, clips.size() - first);
    std::vector<absl::StatusOr<core::BuildInput>> read(count);
    parallel(static_cast<int>(count), [&](int i) {
      read[i] = ReadInput(store, database.name(), *catalog, clips[first + i]);
    });
    for (std::size_t i = 0; i < count; ++i) {
      const std::string& clip = clips[first + i];
      if (absl::IsNotFound(read[i].status())) continue;
      if (absl::IsDataLoss(read[i].status())) {
        database.AddUnreadable(clip, std::string(read[i].status().message()));
        continue;
      }
      if (!read[i].ok()) return read[i].status();
      database.ForgetUnreadable(clip);  // the disk may have recovered
      inputs.push_back(*std::move(read[i]));
    }
  }
  return inputs;
}

}  // namespace motiondb::server
