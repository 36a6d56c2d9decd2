#include "core/calibration/calibrate.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/model/clip_mask.h"
#include "core/model/label_units.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/samples.h"

namespace motiondb::core {

std::vector<bool> LeftOutWith(const Model& model, const LabelUnit& held_out) {
  const std::vector<ModelClip>& clips = model.clips();
  const std::string& subject = clips[held_out.clip].subject;
  const bool leave_out_subject =
      !subject.empty() &&
      std::ranges::any_of(model.action_units()->all(), [&](const LabelUnit& unit) {
        return unit.label == held_out.label && clips[unit.clip].subject != subject;
      });
  std::vector<bool> left_out(clips.size());
  for (std::size_t c = 0; c < clips.size(); ++c) {
    left_out[c] =
        static_cast<int>(c) == held_out.clip || (leave_out_subject && clips[c].subject == subject);
  }
  return left_out;
}

std::shared_ptr<const ClipMask> MaskWithout(const Model& model, std::vector<bool> left_out) {
  left_out.flip();
  auto mask = ClipMask::Create(model, std::move(left_out));
  return mask.ok() ? *std::move(mask) : nullptr;
}

std::vector<LabelUnit> SampleUnits(const Model& model, int max_count) {
  std::vector<LabelUnit> order = model.action_units()->all();
  // Labels are numbered in alphabetical order.
  std::ranges::stable_sort(order, [&](const LabelUnit& a, const LabelUnit& b) {
    return std::tie(a.label, model.clips()[a.clip].subject) <
           std::tie(b.label, model.clips()[b.clip].subject);
  });
  std::vector<LabelUnit> sample;
  for (const int i : SpreadEvenly(std::ssize(order), max_count)) sample.push_back(order[i]);
  return sample;
}

StateSequence StoredMotion(const Model& model, int clip) {
  return StoredMotion(model, clip, 0, model.clips()[clip].frame_count);
}

StateSequence StoredMotion(const Model& model, const LabelUnit& unit) {
  const int first = unit.first_frame - model.clips()[unit.clip].first_frame;
  return StoredMotion(model, unit.clip, first, first + unit.frame_count);
}

StateSequence StoredMotion(const Model& model, int clip, int first, int end) {
  const ModelClip& stored = model.clips()[clip];
  StateSequence motion{model.settings().frame_rate_hz, stored.leg_length_m,
                       model.states().middleRows(stored.first_frame + first, end - first),
                       model.root_path().middleRows(stored.first_frame + first, end - first)};
  model.scale().Revert(motion.states);
  return motion;
}

absl::Status Calibrate(Model& model, const ParallelFor& parallel, const BuildProgress& progress) {
  const auto half_progress = [&](double begin) -> BuildProgress {
    return [&progress, begin](double fraction, std::string_view stage) {
      return !progress || progress(begin + fraction / 2, stage);
    };
  };
  MOTIONDB_ASSIGN_OR_RETURN(RecognitionCalibration recognition,
                            CalibrateRecognition(model, parallel, half_progress(0)));
  MOTIONDB_ASSIGN_OR_RETURN(PredictionConfidence confidence,
                            FitPredictionConfidence(model, parallel, half_progress(0.5)));
  model.set_recognition(std::move(recognition));
  model.set_confidence(std::move(confidence));
  return absl::OkStatus();
}

absl::StatusOr<Model> RefitLabels(Model model, const ParallelFor& parallel,
                                  const BuildProgress& progress) {
  constexpr double kMetricShare = 0.2;  // of the time
  if (progress && !progress(0, "metric")) return absl::CancelledError("the refit was cancelled");
  ModelParts parts = std::move(model).TakeParts();
  parts.metric = FitMotionMetric(parts, parallel);
  parts.recognition = {};
  parts.confidence = {};
  MOTIONDB_ASSIGN_OR_RETURN(Model refitted, Model::Create(std::move(parts), parallel));
  const auto rest = [&](double fraction, std::string_view stage) {
    return !progress || progress(kMetricShare + (1 - kMetricShare) * fraction, stage);
  };
  MOTIONDB_RETURN_IF_ERROR(Calibrate(refitted, parallel, rest));
  return refitted;
}

}  // namespace motiondb::core
