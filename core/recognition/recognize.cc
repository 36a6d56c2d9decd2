#include "core/recognition/recognize.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/inference/node_path.h"
#include "core/inference/observation.h"
#include "core/model/clip_mask.h"
#include "core/model/label_units.h"
#include "core/motion/error.h"
#include "core/recognition/clip_generation.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/shortlist.h"
#include "core/recognition/unknown.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {
namespace {

// Frames of a window x nodes of the layer; 8 bytes each.
constexpr Eigen::Index kMaxCells = 1 << 26;

constexpr std::int64_t kMaxScores = 1 << 23;  // about 40 bytes each

// Checks the number of scores: each window has one for each compared clip and each label.
absl::Status CheckAnswerSize(const Model& model, const ClipMask* mask, std::int64_t labels,
                             bool align, std::int64_t windows) {
  const std::int64_t clips = AllowedCount(model, mask);
  const std::int64_t scores =
      labels + (align ? std::min<std::int64_t>(clips, kMaxShortlisted) : clips);
  if (windows * scores <= kMaxScores) return absl::OkStatus();
  return FieldViolation(
      "hop_seconds",
      "{} windows of {} clips and labels each would need too much memory; use a longer "
      "hop or a shorter observation",
      windows, scores);
}

// Sets the window's scores by generation probability.
absl::Status ScoreByGeneration(const Model& model, const LabelUnits& units,
                               const WindowEmission& emission, const RecognizeOptions& options,
                               const Cancelled& cancelled, RecognizedWindow& window) {
  MOTIONDB_ASSIGN_OR_RETURN(
      std::vector<UnitEvidence> evidence,
      ScoreGeneration(model, window.layer, emission, units, options, cancelled));
  window.labels = LabelsByGeneration(units.labels(), evidence);
  SortByEvidence(evidence);
  window.clips = ClipsOf(units, evidence);
  window.other_tracks = OtherTracks(model, units, evidence, 1, 1);
  window.familiarity = emission.Familiarity();
  return absl::OkStatus();
}

// Sets the window's scores by alignment with the shortlisted clips. Does not set the familiarity if
// the model is not calibrated.
absl::Status ScoreByAlignment(const Model& model, const LabelUnits& units,
                              const MetricObservation& observation,
                              const std::vector<int>& compared, const RecognizeOptions& options,
                              const Cancelled& cancelled, RecognizedWindow& window) {
  MOTIONDB_ASSIGN_OR_RETURN(const WindowAlignment alignment,
                            AlignWindow(model, units, observation, compared, options.mask.get(),
                                        options.whole, cancelled));
  window.clips = ClipsOf(units, alignment.units);
  const AnswerCalibration& calibration = model.recognition().Of(options.whole);
  LabelAnswer answer = LabelsOrUnknown(units.labels(), alignment, calibration);
  window.labels = std::move(answer.labels);
  window.unknown_probability = answer.unknown_probability;
  window.other_tracks =
      OtherTracks(model, units, alignment.units, calibration.weight.At(alignment.frames),
                  1 - answer.unknown_probability.value_or(0));
  window.familiarity = calibration.FamiliarityRank(alignment.familiarity_score);
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckOptions(const RecognizeOptions& options) {
  if (!(options.window_seconds > 0 && std::isfinite(options.window_seconds))) {
    return FieldViolation("window_seconds", "expected more than 0, got {}", options.window_seconds);
  }
  if (!(options.hop_seconds > 0 && std::isfinite(options.hop_seconds))) {
    return FieldViolation("hop_seconds", "expected more than 0, got {}", options.hop_seconds);
  }
  MOTIONDB_RETURN_IF_ERROR(CheckTransitionFloor(options.transition_floor));
  return CheckPathCount(options.path_count);
}

WindowPlan PlanWindows(const Model& model, const StateSequence& observation,
                       const RecognizeOptions& options) {
  const int frames = observation.frame_count();
  const auto in_frames = [&](double seconds) {
    return static_cast<int>(
        std::max(1.0, std::min<double>(std::round(seconds * observation.frame_rate_hz), frames)));
  };
  WindowPlan plan;
  plan.width = options.whole ? frames : in_frames(options.window_seconds);
  plan.hop = in_frames(options.hop_seconds);
  plan.count = 1 + (frames - plan.width) / plan.hop;
  plan.is_aligned = options.method == Method::kBest && !model.metric().empty();
  plan.uses_graph = !plan.is_aligned || model.recognition().Of(options.whole).familiarity.empty();
  return plan;
}

absl::StatusOr<std::vector<RecognizedWindow>> Recognize(const Model& model,
                                                        const StateSequence& observation,
                                                        const RecognizeOptions& options,
                                                        const Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(CheckOptions(options));
  MOTIONDB_ASSIGN_OR_RETURN(const int layer, model.ResolveLayer(options.layer));
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, observation));

  const auto [width, hop, count, align, by_graph] = PlanWindows(model, observation, options);
  if (by_graph && static_cast<Eigen::Index>(width) * model.tree().node_count(layer) > kMaxCells) {
    return FieldViolation("window_seconds",
                          "a window of {} frames over the {} nodes of layer {} would need too much "
                          "memory; use shorter windows or a higher layer",
                          width, model.tree().node_count(layer), layer);
  }

  const Eigen::Index paths = options.generation == Generation::kTopPaths ? options.path_count : 1;
  if (!align &&
      static_cast<Eigen::Index>(width) * model.tree().node_count(layer) > kMaxCells / paths) {
    return FieldViolation("path_count",
                          "{} paths of {} frames over the {} nodes of layer {} would need too much "
                          "memory; use fewer paths, shorter windows or a higher layer",
                          paths, width, model.tree().node_count(layer), layer);
  }
  const ClipMask* const mask = options.mask.get();
  const auto units = UnitsOf(model, options.track, mask);
  MOTIONDB_RETURN_IF_ERROR(CheckAnswerSize(model, mask, std::ssize(units->labels()), align, count));

  MetricObservation in_metric;
  if (align) {
    MOTIONDB_ASSIGN_OR_RETURN(in_metric, MetricObservation::Create(model, scaled, cancelled));
  }
  const double rate = observation.frame_rate_hz;
  const int stride = FrameStride(rate);
  WindowEmission emission(model, layer, scaled, by_graph ? width : 0, mask);
  std::vector<RecognizedWindow> windows;
  for (int i = 0; i < count; ++i) {
    const int first = i * hop;
    RecognizedWindow& window = windows.emplace_back();
    window.start_seconds = first / rate;
    window.end_seconds = (first + width) / rate;
    window.layer = layer;
    if (by_graph) emission.MoveTo(first, cancelled);
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    if (align) {
      MOTIONDB_RETURN_IF_ERROR(ScoreByAlignment(model, *units, in_metric,
                                                ComparedFrames(first, width, stride, options.whole),
                                                options, cancelled, window));
      if (by_graph) window.familiarity = emission.Familiarity();
    } else {
      MOTIONDB_RETURN_IF_ERROR(
          ScoreByGeneration(model, *units, emission, options, cancelled, window));
    }
  }
  return windows;
}

}  // namespace motiondb::core
