#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/calibration/held_out.h"
#include "core/calibration/trials.h"
#include "core/model/even_spread.h"
#include "core/motion/error.h"
#include "core/motion/states.h"
#include "core/prediction/forecast.h"
#include "core/prediction/predict.h"

namespace motiondb::core {
namespace {

constexpr int kMoments = 192;
constexpr int kMostClips = 128;        // moments of different clips say more than those of one
constexpr double kMomentsApart = 0.2;  // s from moment to moment: what is nearer says little more
constexpr int kLeastMoments = 16;      // to fit a law to
constexpr double kLeastFuture = 0.08;  // s

constexpr double kAround = 1.0;    // s to each side of a moment
constexpr double kLongEnough = 4;  // s of a clip that stays an example of itself
constexpr int kAgainEvery = 2;     // moments that are predicted again from their own clip

struct Moment {
  int clip = 0;
  int frame = 0;  // of the clip
  FrameRange without;
};

std::vector<Moment> Moments(const Model& model) {
  const double rate = model.settings().frame_rate_hz;
  const auto past = static_cast<int>(std::ceil(kLags * kLagSeconds * rate));
  const auto future = static_cast<int>(std::ceil(kLeastFuture * rate));
  const std::vector<int> clips = SampleClips(model, kMostClips);
  const int each = kMoments / static_cast<int>(clips.size());
  std::vector<Moment> moments;
  int tries = 0;
  for (const int clip : clips) {
    const ModelClip& stored = model.clips()[clip];
    const int end = stored.first_frame + stored.frame_count;
    const int usable_frames = stored.frame_count - past - future;
    const int apart = static_cast<int>(std::ceil(usable_frames / (kMomentsApart * rate)));
    for (const int usable : SpreadEvenly(usable_frames, std::min(each, apart))) {
      const int frame = past + usable;
      moments.push_back({clip, frame, {stored.first_frame, end}});
      if (stored.frame_count < kLongEnough * rate || ++tries % kAgainEvery != 0) continue;
      const int around = static_cast<int>(kAround * rate);
      const int at = stored.first_frame + frame;
      moments.push_back(
          {clip, frame, {std::max(stored.first_frame, at - around), std::min(end, at + around)}});
    }
  }
  return moments;
}

double MeanDistance(const Eigen::RowVectorXf& a, const Eigen::RowVectorXf& b) {
  return (a - b).reshaped<Eigen::RowMajor>(a.size() / 3, 3).rowwise().norm().mean();
}

// At each horizon that the clip goes on for.
using Trial = std::vector<std::optional<ErrorSample>>;

absl::StatusOr<Trial> Try(const Model& model, const MotionPrior& prior, const Moment& moment,
                          const std::vector<double>& horizons) {
  const PredictOptions options;
  const StateSequence clip = StoredMotion(model, moment.clip);
  const auto history =
      std::max(1, static_cast<int>(std::lround(options.history_seconds * clip.frame_rate_hz)));
  const StateSequence past = PastAt(clip, moment.frame, history);
  MOTIONDB_ASSIGN_OR_RETURN(auto moments,
                            FindMoments(model, past, options.transition_floor, moment.without, {}));
  Forecaster forecaster(model, past, std::move(moments), &prior);
  const Track truth(clip);
  Trial trial;
  for (const double seconds : horizons) {
    const double frames = seconds * clip.frame_rate_hz;
    if (moment.frame + frames > truth.end() - 1 + 1e-6) {
      trial.push_back(std::nullopt);
      continue;
    }
    const Forecast forecast = forecaster.At(seconds);
    trial.push_back(ErrorSample{
        forecast.evidence, MeanDistance(forecast.positions, truth.SeenFrom(moment.frame, frames))});
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
  // The linear prior must not have seen the clip either: it is fitted anew without its part.
  const std::shared_ptr<const MotionSums> kept = model.parts().prior_sums;
  const MotionSums sums = kept == nullptr ? MotionSums::Over(model.parts(), parallel) : *kept;
  std::vector<MotionPrior> priors(MotionSums::kParts);
  parallel(MotionSums::kParts, [&](int part) { priors[part] = sums.Fit(part); });
  std::vector<absl::StatusOr<Trial>> trials(moments.size(), Trial());
  MOTIONDB_RETURN_IF_ERROR(RunTrials(static_cast<int>(moments.size()), "calibration of predictions",
                                     parallel, progress, [&](int i) {
                                       const MotionPrior& prior =
                                           priors[sums.part_of_clip(moments[i].clip)];
                                       trials[i] = Try(model, prior, moments[i], horizons);
                                     }));
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    std::vector<ErrorSample> samples;
    for (const absl::StatusOr<Trial>& trial : trials) {
      if (!trial.ok()) return trial.status();
      if ((*trial)[h]) samples.push_back(*(*trial)[h]);
    }
    if (samples.size() >= kLeastMoments) {
      confidence.laws.push_back(FitErrorLaw(horizons[h], samples));
    }
  }
  return confidence;
}

}  // namespace motiondb::core
