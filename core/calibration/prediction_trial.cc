#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/calibration/calibrate.h"
#include "core/model/label_units.h"
#include "core/motion/error.h"
#include "core/motion/samples.h"
#include "core/motion/states.h"
#include "core/prediction/forecast.h"
#include "core/prediction/predict.h"

namespace motiondb::core {
namespace {

constexpr int kMaxMoments = 192;
constexpr int kMaxPredictedUnits = 128;
constexpr double kMinMomentDistance = 0.2;  // s; closer moments add little information
constexpr int kMinSamples = 16;             // to fit an error model
constexpr double kMinFuture = 0.08;         // s of motion after a moment

// Every second moment is predicted again with its own clip in the model, except the frames around
// the moment: a database often has similar motion of the observed person.
constexpr int kOwnClipEvery = 2;
constexpr double kLeftOutAround = 1.0;     // s, on each side of the moment
constexpr double kMinOwnClipDuration = 4;  // s

struct Moment {
  int clip = 0;
  int frame = 0;        // of the clip, from 0
  FrameRange left_out;  // frames of the model
};

std::vector<Moment> Moments(const Model& model) {
  const double rate = model.settings().frame_rate_hz;
  const auto past = static_cast<int>(std::ceil(kLags * kLagSeconds * rate));
  const auto future = static_cast<int>(std::ceil(kMinFuture * rate));
  const std::vector<LabelUnit> units = SampleUnits(model, kMaxPredictedUnits);
  const int moments_per_unit = kMaxMoments / static_cast<int>(units.size());
  std::vector<Moment> moments;
  int count = 0;
  for (const LabelUnit& unit : units) {
    const int clip = unit.clip;
    const ModelClip& stored = model.clips()[clip];
    const int end = stored.first_frame + stored.frame_count;
    // Frames of the unit with enough frames of the clip before and after them.
    const int first = unit.first_frame - stored.first_frame;
    const int first_usable = std::max(past, first);
    const int usable_frames =
        std::min(stored.frame_count - future, first + unit.frame_count) - first_usable;
    const auto distinct = static_cast<int>(std::ceil(usable_frames / (kMinMomentDistance * rate)));
    for (const int usable : SpreadEvenly(usable_frames, std::min(moments_per_unit, distinct))) {
      const int frame = first_usable + usable;
      moments.push_back({clip, frame, {stored.first_frame, end}});
      if (stored.frame_count < kMinOwnClipDuration * rate || ++count % kOwnClipEvery != 0) continue;
      const int around = static_cast<int>(kLeftOutAround * rate);
      const int model_frame = stored.first_frame + frame;
      moments.push_back({clip,
                         frame,
                         {std::max(stored.first_frame, model_frame - around),
                          std::min(end, model_frame + around)}});
    }
  }
  return moments;
}

double MeanDistance(const Eigen::RowVectorXf& a, const Eigen::RowVectorXf& b) {
  return (a - b).reshaped<Eigen::RowMajor>(a.size() / 3, 3).rowwise().norm().mean();
}

// For each horizon: the error of the prediction, or nullopt if the clip ends before the horizon.
using Trial = std::vector<std::optional<ErrorSample>>;

absl::StatusOr<Trial> PredictMoment(const Model& model, const MotionPrior& prior,
                                    const Moment& moment, const std::vector<double>& horizons) {
  const PredictOptions options;
  const double rate = model.settings().frame_rate_hz;
  const auto history = std::max(1, static_cast<int>(std::lround(options.history_seconds * rate)));
  const int first = std::max(0, moment.frame - history);
  const StateSequence past = PastAt(StoredMotion(model, moment.clip, first, moment.frame + 1),
                                    moment.frame - first, history);
  MOTIONDB_ASSIGN_OR_RETURN(auto moments, FindMoments(model, past, options.transition_floor,
                                                      nullptr, moment.left_out, {}));
  Forecaster forecaster(model, past, std::move(moments), &prior);
  const Track truth(model.parts(), moment.clip);
  const int now = truth.first() + moment.frame;
  Trial trial;
  for (const double seconds : horizons) {
    const double frames = seconds * rate;
    if (now + frames > truth.end() - 1 + 1e-6) {
      trial.push_back(std::nullopt);
      continue;
    }
    const Forecast forecast = forecaster.At(seconds);
    trial.push_back(ErrorSample{forecast.evidence,
                                MeanDistance(forecast.positions, truth.SeenFrom(now, frames))});
  }
  return trial;
}

}  // namespace

absl::StatusOr<PredictionConfidence> FitPredictionConfidence(const Model& model,
                                                             const ParallelFor& parallel,
                                                             const BuildProgress& progress) {
  PredictionConfidence confidence;
  if (model.clips().size() < 2) return confidence;
  const std::vector<double> horizons = PredictOptions().horizon_seconds;
  const std::vector<Moment> moments = Moments(model);
  // The clips are divided into parts. The motion prior of a trial is fitted without the part that
  // contains the clip.
  const std::shared_ptr<const MotionSums> stored_sums = model.parts().prior_sums;
  const MotionSums sums =
      stored_sums == nullptr ? MotionSums::Over(model.parts(), parallel) : *stored_sums;
  std::vector<MotionPrior> priors(MotionSums::kParts);
  parallel(MotionSums::kParts, [&](int part) { priors[part] = sums.Fit(part); });
  std::vector<absl::StatusOr<Trial>> trials(moments.size(), Trial());
  MOTIONDB_RETURN_IF_ERROR(RunTrials(static_cast<int>(moments.size()), "calibration of predictions",
                                     parallel, progress, [&](int i) {
                                       const MotionPrior& prior =
                                           priors[sums.part_of_clip(moments[i].clip)];
                                       trials[i] =
                                           PredictMoment(model, prior, moments[i], horizons);
                                     }));
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    std::vector<ErrorSample> samples;
    for (const absl::StatusOr<Trial>& trial : trials) {
      if (!trial.ok()) return trial.status();
      if ((*trial)[h]) samples.push_back(*(*trial)[h]);
    }
    if (samples.size() >= kMinSamples) {
      confidence.models.push_back(FitErrorModel(horizons[h], samples));
    }
  }
  return confidence;
}

}  // namespace motiondb::core
