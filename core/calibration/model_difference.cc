#include "core/calibration/model_difference.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/model/clip_mask.h"
#include "core/model/label_units.h"
#include "core/motion/samples.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {
namespace {

constexpr int kMaxFrames = 20000;
constexpr int kComparedWindows = 64;
constexpr double kComparedWindowSeconds = 0.4;

double Spread(const Model& model) {
  const int bottom = model.layer_count();
  const std::vector<int> frames = SpreadEvenly(model.frame_count(), kMaxFrames);
  double sum = 0;
  for (const int f : frames) {
    const int branch = model.tree().branch(bottom, model.tree().node_of_frame(bottom, f));
    sum += (model.states().row(f) - model.gaussians().means().row(branch)).squaredNorm();
  }
  return std::sqrt(sum / (static_cast<double>(frames.size()) * model.states().cols()));
}

// Recognizes `width` frames of a clip, from frame `first`, without the clips of LeftOutWith of the
// unit in their middle. Returns the most probable label; empty if no label remains.
std::string MostProbableLabel(const Model& model, int clip, int first, int width) {
  const int first_frame = model.clips()[clip].first_frame + first;
  const auto of_clip = model.action_units()->of_clip(clip);
  const auto unit = std::ranges::find_if(of_clip, [&](const LabelUnit& u) {
    return first_frame + width / 2 < u.first_frame + u.frame_count;
  });
  const auto mask = MaskWithout(model, LeftOutWith(model, *unit));
  if (mask == nullptr) return "";
  const auto units = UnitsOf(model, kActionTrack, mask.get());
  if (units->labels().empty()) return "";
  const FrameMatrix scaled = model.states().middleRows(first_frame, width);
  const auto observation = MetricObservation::Create(model, scaled);
  const auto alignment =
      AlignWindow(model, *units, *observation,
                  ComparedFrames(0, width, FrameStride(model.settings().frame_rate_hz), false),
                  mask.get(), false, {});
  const std::vector<double> evidence = LabelEvidence(units->labels().size(), alignment->units);
  return units->labels()[std::ranges::max_element(evidence) - evidence.begin()];
}

}  // namespace

ModelDifference CompareModels(const Model& before, const Model& after,
                              const ParallelFor& parallel) {
  ModelDifference difference{.bottom_nodes_before = before.tree().node_count(before.layer_count()),
                             .bottom_nodes_after = after.tree().node_count(after.layer_count()),
                             .spread_before = Spread(before),
                             .spread_after = Spread(after)};
  if (before.metric().empty() || after.metric().empty()) return difference;
  std::map<std::string, int> index_after;  // by clip id
  for (std::size_t c = 0; c < after.clips().size(); ++c) {
    index_after[after.clips()[c].id] = static_cast<int>(c);
  }
  std::vector<int> common;  // added clips that are in both models; indices in `before`
  for (int c = before.built_clip_count(); c < std::ssize(before.clips()); ++c) {
    const auto found = index_after.find(before.clips()[c].id);
    if (found != index_after.end() &&
        after.clips()[found->second].frame_count == before.clips()[c].frame_count) {
      common.push_back(c);
    }
  }
  const std::vector<int> tested = SpreadEvenly(static_cast<int>(common.size()), kComparedWindows);
  const auto full_width =
      static_cast<int>(std::lround(kComparedWindowSeconds * before.settings().frame_rate_hz));
  std::vector<char> same_label(tested.size());
  parallel(static_cast<int>(tested.size()), [&](int i) {
    const int clip = common[tested[i]];
    const int frames = before.clips()[clip].frame_count;
    const int width = std::clamp(full_width, 1, frames);
    const int first = (frames - width) / 2;
    same_label[i] = MostProbableLabel(before, clip, first, width) ==
                    MostProbableLabel(after, index_after.at(before.clips()[clip].id), first, width);
  });
  difference.windows = static_cast<int>(tested.size());
  difference.same_label = static_cast<int>(std::ranges::count(same_label, 1));
  return difference;
}

}  // namespace motiondb::core
