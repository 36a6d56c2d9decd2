#include "core/model/model_builder.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/model/clip_graphs.h"
#include "core/model/shared_rows.h"
#include "core/motion/error.h"
#include "core/tree/tree_builder.h"

namespace motiondb::core {
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

}  // namespace motiondb::core
