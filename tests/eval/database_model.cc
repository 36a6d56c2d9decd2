#include "tests/eval/database_model.h"

#include <utility>

#include "core/calibration/calibrate.h"
#include "core/model/model_builder.h"
#include "core/motion/error.h"

namespace motiondb::tests {
namespace {

double GraphBytes(const core::TransitionGraph& graph) {
  return static_cast<double>(sizeof(core::Edge)) * graph.edge_count() + 4.0 * graph.node_count();
}

}  // namespace

absl::StatusOr<core::Model> BuildEvalModel(const core::MarkerSet& set, const ClipSet& training) {
  std::vector<core::BuildInput> inputs;
  for (const EvalClip* clip : training) {
    inputs.push_back({clip->name, clip->label, clip->states, clip->source});
  }
  core::BuildSettings settings;
  settings.frame_rate_hz = training.front()->states.frame_rate_hz;
  MOTIONDB_ASSIGN_OR_RETURN(
      core::Model model, core::BuildModel(settings, set, std::move(inputs), core::RunSerially, {}));
  MOTIONDB_RETURN_IF_ERROR(core::Calibrate(model, core::RunSerially, {}));
  return model;
}

double ModelBytes(const core::Model& model) {
  double bytes = 4.0 * static_cast<double>(model.states().size()) +
                 8.0 * static_cast<double>(model.gaussians().means().size());
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    bytes += GraphBytes(model.global_graph(layer));
  }
  for (const auto& graph : model.parts().clip_graphs) {
    bytes += GraphBytes(graph->transitions) + 8.0 * static_cast<double>(graph->nodes.size());
  }
  for (const auto& scores : model.familiarity().scores) {
    bytes += 4.0 * static_cast<double>(scores.size());
  }
  const core::MotionMetric& metric = model.metric();
  bytes += 4.0 * static_cast<double>(metric.whitening.size() + metric.projection.size() +
                                     metric.loadings.size() + model.prior().weights.size() +
                                     model.metric_frames().projected.size());
  return bytes;
}

}  // namespace motiondb::tests
