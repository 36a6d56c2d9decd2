#include "core/model/model_builder.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/model/clip_graphs.h"
#include "core/model/shared_rows.h"
#include "core/motion/error.h"
#include "core/tree/tree_builder.h"

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace motiondb::core {

absl::Status CheckInputs(const BuildSettings& settings, const MarkerSet& marker_set,
                         const std::vector<BuildInput>& inputs) {
  if (inputs.empty()) return InvalidArgument("expected at least one clip, got none");
  for (const BuildInput& input : inputs) {
    const StateSequence& states = input.states;
    if (states.frame_count() == 0 || states.root_path.rows() != states.frame_count()) {
      return InvalidArgument(
          "clip '{}': expected at least one frame and a root pose for each frame", input.clip_id);
    }
    if (states.states.cols() != marker_set.dimension_count()) {
      return InvalidArgument("clip '{}': expected {} dimensions, got {}", input.clip_id,
                             marker_set.dimension_count(), states.states.cols());
    }
    if (std::abs(states.frame_rate_hz - settings.frame_rate_hz) > 1e-6) {
      return InvalidArgument("clip '{}': expected {} Hz, got {} Hz", input.clip_id,
                             settings.frame_rate_hz, states.frame_rate_hz);
    }
    if (!states.states.allFinite() || !states.root_path.allFinite()) {
      return InvalidArgument("clip '{}': expected finite states and root path", input.clip_id);
    }
    LabelTracks labels = input.labels;
    labels.Resolve(states.frame_count());
    if (const absl::Status fits = labels.Check(states.frame_count()); !fits.ok()) {
      return InvalidArgument("clip '{}': {}", input.clip_id, std::string(fits.message()));
    }
  }
  return absl::OkStatus();
}

namespace {

constexpr std::int64_t kFreedBytes = 64 << 20;  // freed between two calls of malloc_trim

// Returns freed memory to the operating system. Otherwise fragmentation doubles the memory that a
// build needs for its clips.
void ReturnFreedMemory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace

ConcatenatedInputs Concatenate(std::vector<BuildInput> inputs) {
  Eigen::Index frames = 0;
  for (const BuildInput& input : inputs) frames += input.states.frame_count();
  ConcatenatedInputs concatenated;
  concatenated.states.resize(frames, inputs[0].states.states.cols());
  concatenated.root_path.resize(frames, 3);
  std::int32_t first = 0;
  for (BuildInput& input : inputs) {
    const int count = input.states.frame_count();
    concatenated.clips.push_back({std::move(input.clip_id), std::move(input.labels), first, count,
                                  input.states.leg_length_m, std::move(input.subject),
                                  std::move(input.states.glitches)});
    concatenated.clips.back().labels.Resolve(count);
    first += count;
  }
  std::int64_t freed = 0;
  for (std::size_t c = 0; c < inputs.size(); ++c) {
    const ModelClip& clip = concatenated.clips[c];
    concatenated.states.middleRows(clip.first_frame, clip.frame_count) = inputs[c].states.states;
    concatenated.root_path.middleRows(clip.first_frame, clip.frame_count) =
        inputs[c].states.root_path;
    inputs[c].states = {};
    freed += clip.frame_count * concatenated.states.cols() * std::int64_t{sizeof(float)};
    if (freed < kFreedBytes) continue;
    ReturnFreedMemory();
    freed = 0;
  }
  ReturnFreedMemory();
  return concatenated;
}

namespace {

constexpr double kFamiliarityWindowSeconds = 0.4;  // the default window of a query

void CountGraphs(const ParallelFor& parallel, ModelParts& parts) {
  parts.global_graphs.resize(parts.tree.layer_count());
  parallel(parts.tree.layer_count(), [&](int l) {
    parts.global_graphs[l] = CountGlobalGraph(parts.tree, l + 1, parts.clips);
  });
  parts.clip_graphs.resize(parts.clips.size());
  parallel(static_cast<int>(parts.clips.size()), [&](int c) {
    parts.clip_graphs[c] =
        std::make_shared<const ClipGraph>(CountClipGraph(parts.tree, parts.clips[c]));
  });
}

}  // namespace

absl::StatusOr<Model> BuildModel(const BuildSettings& settings, const MarkerSet& marker_set,
                                 std::vector<BuildInput> inputs, const ParallelFor& parallel,
                                 const BuildProgress& progress) {
  MOTIONDB_RETURN_IF_ERROR(CheckInputs(settings, marker_set, inputs));
  const auto report = [&](double fraction, const std::string& stage) -> absl::Status {
    if (progress && !progress(fraction, stage)) {
      return absl::CancelledError("the build was cancelled");
    }
    return absl::OkStatus();
  };

  ModelParts parts;
  parts.settings = settings;
  parts.marker_set = marker_set;
  MOTIONDB_RETURN_IF_ERROR(report(0, "states"));
  ConcatenatedInputs concatenated = Concatenate(std::move(inputs));
  parts.scale = MakeFeatureScale(settings.scaling, concatenated.states, parallel);
  const Eigen::Index room = RoomToGrow(concatenated.states.rows());
  concatenated.states.conservativeResize(concatenated.states.rows() + room, Eigen::NoChange);
  parts.clips = std::move(concatenated.clips);
  parts.root_path = std::move(concatenated.root_path);
  Eigen::Map<FrameMatrix> scaled(concatenated.states.data(), concatenated.states.rows() - room,
                                 concatenated.states.cols());
  ScaleInPlace(parts.scale, scaled, parallel);

  // The depth is unknown, so each layer adds 15 % of the remaining progress.
  const auto layer_done = [&](int layer) {
    return report(0.8 * (1 - std::pow(0.85, layer)), fmt::format("tree, layer {}", layer)).ok();
  };
  MOTIONDB_ASSIGN_OR_RETURN(parts.tree,
                            BuildTreeInPlace(scaled, settings.min_frames, parallel, layer_done));
  parts.states = SharedRows(std::move(concatenated.states), room);
  const auto states = parts.states.view();
  MOTIONDB_RETURN_IF_ERROR(report(0.8, "node statistics"));
  parts.gaussians = NodeGaussians::Fit(parts.tree, states, parallel);
  MOTIONDB_RETURN_IF_ERROR(report(0.85, "transition graphs"));
  CountGraphs(parallel, parts);
  MOTIONDB_RETURN_IF_ERROR(report(0.9, "familiarity"));
  std::vector<FrameRun> runs;
  for (const ModelClip& clip : parts.clips) runs.push_back({clip.first_frame, clip.frame_count});
  const int window = std::max(
      1, static_cast<int>(std::lround(kFamiliarityWindowSeconds * settings.frame_rate_hz)));
  parts.familiarity = MakeFamiliarityReference(runs, window, states, parts.tree, parts.gaussians,
                                               parts.global_graphs, parallel);
  MOTIONDB_RETURN_IF_ERROR(report(0.93, "motion prior"));
  parts.prior_sums = std::make_shared<const MotionSums>(MotionSums::Over(parts, parallel));
  parts.prior = parts.prior_sums->Fit();
  MOTIONDB_RETURN_IF_ERROR(report(0.96, "metric"));
  parts.metric = FitMotionMetric(parts, parallel);
  MOTIONDB_RETURN_IF_ERROR(report(1, "done"));
  return Model::Create(std::move(parts), parallel);
}

namespace {

// Returns the parts that an extension does not change.
ModelParts FittedParts(const Model& base) {
  ModelParts parts;
  parts.settings = base.settings();
  parts.marker_set = base.marker_set();
  parts.built_clip_count = base.built_clip_count();
  parts.scale = base.scale();
  parts.familiarity = base.familiarity();
  parts.prior = base.prior();
  parts.metric = base.metric();
  parts.recognition = base.recognition();
  parts.confidence = base.confidence();
  parts.build_seconds = base.build_seconds();
  return parts;
}

// Appends states, root path and clips. Returns the new clips with their frame numbers in the model.
std::vector<ModelClip> AppendFrames(const Model& base, ConcatenatedInputs added,
                                    ModelParts& parts) {
  base.scale().Apply(added.states);
  parts.states = base.parts().states.WithMore(std::move(added.states));
  parts.root_path.resize(parts.states.rows(), 3);
  parts.root_path << base.root_path(), added.root_path;
  parts.clips = base.clips();
  for (ModelClip& clip : added.clips) clip.first_frame += base.frame_count();
  parts.clips.insert(parts.clips.end(), added.clips.begin(), added.clips.end());
  return std::move(added.clips);
}

void AppendGraphs(const Model& base, const std::vector<ModelClip>& added,
                  const ParallelFor& parallel, ModelParts& parts) {
  parts.clip_graphs = base.parts().clip_graphs;
  for (const ModelClip& clip : added) {
    parts.clip_graphs.push_back(
        std::make_shared<const ClipGraph>(CountClipGraph(parts.tree, clip)));
  }
  parts.global_graphs.resize(base.layer_count());
  parallel(base.layer_count(), [&](int l) {
    parts.global_graphs[l] =
        MergeGraphs(base.global_graph(l + 1), CountGlobalGraph(parts.tree, l + 1, added));
  });
}

}  // namespace

absl::StatusOr<Model> ExtendModel(const Model& base, std::vector<BuildInput> inputs,
                                  const ParallelFor& parallel) {
  MOTIONDB_RETURN_IF_ERROR(CheckInputs(base.settings(), base.marker_set(), inputs));
  if (!base.tree().has_planes()) {
    return FailedPrecondition(
        "the model was built by an older version and cannot be extended; rebuild it");
  }
  ModelParts parts = FittedParts(base);
  const std::vector<ModelClip> added = AppendFrames(base, Concatenate(std::move(inputs)), parts);
  const auto states = parts.states.view();
  MOTIONDB_ASSIGN_OR_RETURN(
      parts.tree, GrowTree(base.tree(), states.bottomRows(states.rows() - base.frame_count())));
  parts.gaussians = base.gaussians().Grown(parts.tree, base.frame_count(), states, parallel);
  AppendGraphs(base, added, parallel, parts);
  return Model::Create(std::move(parts), base);
}

ModelDrift MeasureDrift(const Model& model, const ParallelFor& parallel) {
  const int built = model.built_frame_count();
  return {
      1 - static_cast<double>(built) / model.frame_count(),
      DriftFraction(model.tree(), built, model.states(), model.settings().min_frames, parallel)};
}

}  // namespace motiondb::core
