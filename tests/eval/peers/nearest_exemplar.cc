#include "tests/eval/peers/nearest_exemplar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/motion/error.h"

namespace motiondb::tests {
namespace {

constexpr int kHistory = 10;       // past frames that tuning compares
constexpr int kChoosingStep = 10;  // frames

// Candidates that differ only in the last number are adjacent: they share their exemplars.
std::vector<ExemplarOptions> Candidates() {
  std::vector<ExemplarOptions> candidates;
  for (const int lags : {1, 3}) {
    for (const double step_weight : {1.0, 3.0, 6.0, 12.0}) {
      for (const int exemplars : {1, 8, 32}) {
        for (const double step_decay : {0.0, 0.5, 0.7, 0.85, 0.95}) {
          candidates.push_back({lags, step_weight, exemplars, step_decay});
        }
      }
    }
  }
  return candidates;
}

bool SameExemplars(const ExemplarOptions& a, const ExemplarOptions& b) {
  return a.lags == b.lags && a.step_weight == b.step_weight && a.exemplars == b.exemplars;
}

double MeanDistance(const Eigen::RowVectorXf& a, const Eigen::RowVectorXf& b) {
  double sum = 0;
  for (Eigen::Index m = 0; m < a.size() / 3; ++m) {
    sum += (a.segment<3>(3 * m) - b.segment<3>(3 * m)).norm();
  }
  return sum / (static_cast<double>(a.size()) / 3);
}

std::vector<int> InFrames(const std::vector<double>& horizons, double frame_rate_hz) {
  std::vector<int> frames;
  for (const double seconds : horizons) {
    frames.push_back(static_cast<int>(std::lround(seconds * frame_rate_hz)));
  }
  return frames;
}

// Returns differences from the previous frame; the first row is 0.
core::FrameMatrix StepsOf(const core::FrameMatrix& positions) {
  core::FrameMatrix steps = core::FrameMatrix::Zero(positions.rows(), positions.cols());
  const Eigen::Index moves = positions.rows() - 1;
  steps.bottomRows(moves) = positions.bottomRows(moves) - positions.topRows(moves);
  return steps;
}

}  // namespace

struct NearestExemplar::Past {
  core::FrameMatrix positions;  // observed x stored frames: squared distances
  core::FrameMatrix steps;
};

void NearestExemplar::Store(const ClipSet& training) {
  Eigen::Index frames = 0;
  for (const EvalClip* clip : training) frames += clip->markers.positions_m.rows();
  core::FrameMatrix positions(frames, training.front()->markers.positions_m.cols());
  core::FrameMatrix steps(frames, positions.cols());
  int at = 0;
  for (const EvalClip* clip : training) {
    const core::FrameMatrix& own = clip->markers.positions_m;
    positions.middleRows(at, own.rows()) = own;
    steps.middleRows(at, own.rows()) = StepsOf(own);
    clip_begin_.push_back(at);
    at += static_cast<int>(own.rows());
  }
  clip_begin_.push_back(at);
  positions_ = StoredFrames(std::move(positions));
  steps_ = StoredFrames(std::move(steps));
}

NearestExemplar::Past NearestExemplar::Compare(const core::FrameMatrix& observed) const {
  return {DistancesTo(positions_, observed).squares,
          DistancesTo(steps_, StepsOf(observed)).squares};
}

std::vector<NearestExemplar::Exemplar> NearestExemplar::Exemplars(const Past& past,
                                                                  const ExemplarOptions& options,
                                                                  int furthest,
                                                                  int left_out) const {
  const auto now = static_cast<int>(past.positions.rows()) - 1;
  const int lags = std::min(options.lags, now);  // the first observed frame has no step
  const auto step_weight = static_cast<float>(options.step_weight * options.step_weight);
  std::vector<std::pair<float, int>> nearest;
  for (int clip = 0; clip + 1 < static_cast<int>(clip_begin_.size()); ++clip) {
    if (clip == left_out) continue;
    for (int f = clip_begin_[clip] + lags; f + furthest < clip_begin_[clip + 1]; ++f) {
      float sum = 0;
      for (int lag = 0; lag < lags; ++lag) {
        sum += past.positions(now - lag, f - lag) + step_weight * past.steps(now - lag, f - lag);
      }
      nearest.emplace_back(sum, f);
    }
  }
  const auto kept = std::min<std::size_t>(options.exemplars, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(kept),
                    nearest.end());
  nearest.resize(kept);
  std::vector<Exemplar> exemplars;
  if (nearest.empty()) return exemplars;
  const double closest = nearest.front().first;
  const double spread = std::max(nearest[kept / 2].first - closest, 1e-12);
  double sum = 0;
  for (const auto& [distance, frame] : nearest) {
    exemplars.push_back({std::exp(-0.5 * (distance - closest) / spread), frame});
    sum += exemplars.back().weight;
  }
  for (Exemplar& exemplar : exemplars) exemplar.weight /= sum;
  return exemplars;
}

Eigen::RowVectorXf NearestExemplar::Future(const core::FrameMatrix& observed,
                                           const std::vector<Exemplar>& exemplars,
                                           double step_decay, int ahead) const {
  const Eigen::Index now = observed.rows() - 1;
  Eigen::RowVectorXf future = observed.row(now);
  Eigen::RowVectorXf step = Eigen::RowVectorXf::Zero(future.size());
  for (const Exemplar& exemplar : exemplars) {
    const auto weight = static_cast<float>(exemplar.weight);
    future += weight * (positions_.frames.row(exemplar.frame + ahead) -
                        positions_.frames.row(exemplar.frame));
    step += weight * steps_.frames.row(exemplar.frame);
  }
  // The sum decay + decay^2 + ... scales the difference of the present step.
  double share = 0;
  for (int i = 1; i <= ahead; ++i) share += std::pow(step_decay, i);
  return future + static_cast<float>(share) * (observed.row(now) - observed.row(now - 1) - step);
}

void NearestExemplar::Learn(const ClipSet& training, const ExemplarOptions& options) {
  Store(training);
  options_ = {options};
}

absl::Status NearestExemplar::Fit(const ClipSet& training, const std::vector<double>& horizons) {
  Store(training);
  const std::vector<int> ahead = InFrames(horizons, training.front()->markers.frame_rate_hz);
  const int furthest = *std::max_element(ahead.begin(), ahead.end());
  const std::vector<ExemplarOptions> candidates = Candidates();
  Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(candidates.size()),
                                                 static_cast<Eigen::Index>(ahead.size()));
  for (int clip = 0; clip < static_cast<int>(training.size()); ++clip) {
    for (int f = clip_begin_[clip] + kHistory; f + furthest < clip_begin_[clip + 1];
         f += kChoosingStep) {
      const core::FrameMatrix observed = positions_.frames.middleRows(f + 1 - kHistory, kHistory);
      const Past past = Compare(observed);
      std::vector<Exemplar> exemplars;
      for (std::size_t c = 0; c < candidates.size(); ++c) {
        if (c == 0 || !SameExemplars(candidates[c], candidates[c - 1])) {
          exemplars = Exemplars(past, candidates[c], furthest, clip);
        }
        for (std::size_t h = 0; h < ahead.size(); ++h) {
          errors(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(h)) +=
              MeanDistance(Future(observed, exemplars, candidates[c].step_decay, ahead[h]),
                           positions_.frames.row(f + ahead[h]));
        }
      }
    }
  }
  chosen_ =
      "by leaving each training clip out in turn; for each horizon: lags/step "
      "weight/exemplars/step decay ";
  for (std::size_t h = 0; h < ahead.size(); ++h) {
    Eigen::Index best = 0;
    errors.col(static_cast<Eigen::Index>(h)).minCoeff(&best);
    const ExemplarOptions& options = options_.emplace_back(candidates[best]);
    chosen_ += fmt::format("{}{}/{}/{}/{}", h == 0 ? "" : ", ", options.lags, options.step_weight,
                           options.exemplars, options.step_decay);
  }
  return absl::OkStatus();
}

absl::StatusOr<Forecast> NearestExemplar::Predict(const core::MarkerMotion& past,
                                                  const std::vector<double>& horizons) const {
  const std::vector<int> ahead = InFrames(horizons, past.frame_rate_hz);
  const int furthest = *std::max_element(ahead.begin(), ahead.end());
  const Past compared = Compare(past.positions_m);
  Forecast forecast;
  forecast.positions_m.resize(static_cast<Eigen::Index>(ahead.size()), past.positions_m.cols());
  std::vector<Exemplar> exemplars;
  for (std::size_t h = 0; h < ahead.size(); ++h) {
    const ExemplarOptions& options = options_[std::min(h, options_.size() - 1)];
    if (h == 0 || (h < options_.size() && !SameExemplars(options, options_[h - 1]))) {
      exemplars = Exemplars(compared, options, furthest, -1);
    }
    if (exemplars.empty()) {
      return core::FailedPrecondition("expected a stored clip longer than the furthest horizon");
    }
    forecast.positions_m.row(static_cast<Eigen::Index>(h)) =
        Future(past.positions_m, exemplars, options.step_decay, ahead[h]);
  }
  return forecast;
}

double NearestExemplar::model_bytes() const {
  return 4.0 * static_cast<double>(positions_.frames.size() + steps_.frames.size());
}

}  // namespace motiondb::tests
