#include "core/model/extend_model.h"

#include <memory>
#include <utility>

#include "core/model/clip_graphs.h"
#include "core/motion/error.h"
#include "core/tree/tree_builder.h"

namespace motiondb::core {
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
