#include "core/model/model_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/motion/error.h"
#include "core/tree/tree_builder.h"

namespace motiondb::core {
namespace {

constexpr double kFamiliarityWindowSeconds = 0.4;  // the default window of a query

absl::Status CheckInputs(const BuildSettings& settings, const MarkerSet& marker_set,
                         const std::vector<BuildInput>& inputs) {
  if (inputs.empty()) return InvalidArgument("a model needs at least one clip");
  for (const BuildInput& input : inputs) {
    const StateSequence& states = input.states;
    if (states.frame_count() == 0 || states.root_path.rows() != states.frame_count()) {
      return InvalidArgument("clip '{}' has no frames, or not a root pose for each", input.clip_id);
    }
    if (states.states.cols() != marker_set.dimension_count()) {
      return InvalidArgument("clip '{}': expected {} dimensions, got {}", input.clip_id,
                             marker_set.dimension_count(), states.states.cols());
    }
    if (std::abs(states.frame_rate_hz - settings.frame_rate_hz) > 1e-6) {
      return InvalidArgument("clip '{}': expected {} frames a second, got {}", input.clip_id,
                             settings.frame_rate_hz, states.frame_rate_hz);
    }
    if (!states.states.allFinite() || !states.root_path.allFinite()) {
      return InvalidArgument("clip '{}' has a number that is not finite", input.clip_id);
    }
  }
  return absl::OkStatus();
}

// Clips end to end, each input's memory given back as soon as it is copied.
void Concatenate(std::vector<BuildInput>& inputs, ModelParts& parts) {
  Eigen::Index frames = 0;
  for (const BuildInput& input : inputs) frames += input.states.frame_count();
  parts.states.resize(frames, parts.marker_set.dimension_count());
  parts.root_path.resize(frames, 3);
  std::int32_t first = 0;
  for (BuildInput& input : inputs) {
    const int count = input.states.frame_count();
    parts.states.middleRows(first, count) = input.states.states;
    parts.root_path.middleRows(first, count) = input.states.root_path;
    parts.clips.push_back({std::move(input.clip_id), std::move(input.label), first, count,
                           input.states.leg_length_m, std::move(input.subject)});
    input.states = {};
    first += count;
  }
}

void CountGraphs(const ParallelFor& parallel, ModelParts& parts) {
  const int layers = parts.tree.layer_count();
  parts.global_graphs.resize(layers);
  parts.clip_graphs.resize(layers);
  parallel(layers, [&](int l) {
    std::vector<std::vector<std::int32_t>> sequences;
    for (const ModelClip& clip : parts.clips) {
      std::vector<std::int32_t>& sequence = sequences.emplace_back();
      sequence.reserve(clip.frame_count);
      for (int f = 0; f < clip.frame_count; ++f) {
        sequence.push_back(parts.tree.node_of_frame(l + 1, clip.first_frame + f));
      }
      parts.clip_graphs[l].push_back(CountClipTransitions(sequence));
    }
    parts.global_graphs[l] = CountTransitions(sequences, parts.tree.node_count(l + 1));
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
  Concatenate(inputs, parts);
  parts.scale = MakeFeatureScale(settings.scaling, parts.states);
  parts.scale.Apply(parts.states);

  // The depth is not known beforehand: progress closes half of what is left with each few layers.
  const auto layer_done = [&](int layer) {
    return report(0.8 * (1 - std::pow(0.85, layer)), fmt::format("tree, layer {}", layer)).ok();
  };
  MOTIONDB_ASSIGN_OR_RETURN(parts.tree,
                            BuildTree(parts.states, settings.min_frames, parallel, layer_done));
  MOTIONDB_RETURN_IF_ERROR(report(0.8, "node statistics"));
  parts.gaussians = NodeGaussians::Fit(parts.tree, parts.states, parallel);
  MOTIONDB_RETURN_IF_ERROR(report(0.85, "transition graphs"));
  CountGraphs(parallel, parts);
  MOTIONDB_RETURN_IF_ERROR(report(0.9, "familiarity"));
  std::vector<FrameRun> runs;
  for (const ModelClip& clip : parts.clips) runs.push_back({clip.first_frame, clip.frame_count});
  const int window = std::max(
      1, static_cast<int>(std::lround(kFamiliarityWindowSeconds * settings.frame_rate_hz)));
  parts.familiarity = MakeFamiliarityReference(runs, window, parts.states, parts.tree,
                                               parts.gaussians, parts.global_graphs, parallel);
  MOTIONDB_RETURN_IF_ERROR(report(0.93, "how motion goes on"));
  parts.prior = MotionSums::Over(parts, parallel).Fit();
  MOTIONDB_RETURN_IF_ERROR(report(0.96, "which differences matter"));
  parts.metric = FitMotionMetric(parts, parallel);
  MOTIONDB_RETURN_IF_ERROR(report(1, "done"));
  return Model::Create(std::move(parts));
}

}  // namespace motiondb::core
