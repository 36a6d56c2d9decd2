#include "core/model/motion_prior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/model/even_spread.h"
#include "core/model/model.h"
#include "core/motion/mirror.h"

namespace motiondb::core {
namespace {

constexpr double kHorizons[] = {0.08, 0.16, 0.32,
                                0.4,  0.56, 1.0};  // s, those of a query by default
constexpr int kMostMoments = 2500;
constexpr double kApart = 0.04;  // s from moment to moment, at least: nearer ones say little more
constexpr Eigen::Index kFeatureRows = 128;  // of features that are summed at a time
// Leg lengths squared. A prior, so it does not grow with what is stored; flat from 1 to 10.
constexpr double kPriorRidge = 2.8;
constexpr float kStill = 1e-4F;  // features that are less throughout are left out

struct Moment {
  int clip = 0;
  int frame = 0;
};

std::vector<Moment> Moments(const ModelParts& parts) {
  const double rate = parts.settings.frame_rate_hz;
  const auto past = static_cast<int>(std::ceil(kLags * kLagSeconds * rate - 1e-6));
  const auto future = static_cast<int>(std::ceil(std::end(kHorizons)[-1] * rate - 1e-6));
  const int step = std::max(1, static_cast<int>(std::lround(kApart * rate)));
  std::vector<Moment> all;
  for (std::size_t c = 0; c < parts.clips.size(); ++c) {
    const ModelClip& clip = parts.clips[c];
    for (int f = clip.first_frame + past; f + future < clip.first_frame + clip.frame_count;
         f += step) {
      if (clip.HasGlitch(f - past, f + future)) continue;
      all.push_back({static_cast<int>(c), f});
    }
  }
  std::vector<Moment> spread;
  for (const int i : SpreadEvenly(std::ssize(all), kMostMoments)) spread.push_back(all[i]);
  return spread;
}

// Sums over a part of the moments, in blocks of rows that are as fast as a matrix product.
void SumOver(const ModelParts& parts, const std::vector<Moment>& moments, std::size_t begin,
             std::size_t end, const std::vector<int>& sides, Eigen::MatrixXf& gram,
             Eigen::MatrixXf& products) {
  const Eigen::Index numbers = 3 * parts.marker_set.marker_count();
  const Eigen::Index features = (1 + kLags) * numbers;
  const auto horizons = static_cast<Eigen::Index>(std::size(kHorizons));
  gram.setZero(features, features);
  products.setZero(features, horizons * numbers);
  FrameMatrix x(kFeatureRows, features);
  FrameMatrix y(kFeatureRows, horizons * numbers);
  Eigen::Index row = 0;
  const auto add = [&] {
    if (row == 0) return;  // Eigen divides by the number of rows
    gram.selfadjointView<Eigen::Lower>().rankUpdate(x.topRows(row).transpose());
    products.noalias() += x.topRows(row).transpose() * y.topRows(row);
    row = 0;
  };
  for (std::size_t i = begin; i < end; ++i) {
    const Track track(parts, moments[i].clip);
    const FrameMatrix history = HistoryAt(track, moments[i].frame);
    FrameMatrix future(horizons, numbers);
    for (Eigen::Index h = 0; h < horizons; ++h) {
      future.row(h) =
          track.SeenFrom(moments[i].frame, kHorizons[h] * track.frame_rate_hz()) - history.row(0);
    }
    x.row(row) = MotionFeatures(history);
    y.row(row++) = future.reshaped<Eigen::RowMajor>().transpose();
    if (!sides.empty()) {
      x.row(row) = MotionFeatures(MirrorPositions(sides, history));
      y.row(row++) = MirrorPositions(sides, future).reshaped<Eigen::RowMajor>().transpose();
    }
    if (row + 2 > kFeatureRows) add();
  }
  add();
}

}  // namespace

Eigen::RowVectorXf MotionPrior::Displacement(const Eigen::RowVectorXf& features,
                                             double at_seconds) const {
  const Eigen::Index numbers = features.size() / (1 + kLags);
  const auto at = [&](std::size_t h) -> Eigen::RowVectorXf {
    return features * weights.middleCols(static_cast<Eigen::Index>(h) * numbers, numbers);
  };
  if (seconds.empty()) return Eigen::RowVectorXf::Zero(numbers);
  const auto after = static_cast<std::size_t>(
      std::lower_bound(seconds.begin(), seconds.end(), at_seconds - 1e-9) - seconds.begin());
  if (after == seconds.size()) return at(after - 1);
  const double from = after == 0 ? 0 : seconds[after - 1];
  const auto share = static_cast<float>((at_seconds - from) / (seconds[after] - from));
  Eigen::RowVectorXf displacement = share * at(after);
  if (after > 0 && share < 1 - 1e-6F) displacement += (1 - share) * at(after - 1);
  return displacement;
}

MotionSums MotionSums::Over(const ModelParts& parts, const ParallelFor& parallel) {
  MotionSums sums;
  sums.part_of_clip_.assign(parts.clips.size(), 0);
  const std::vector<Moment> moments = Moments(parts);
  sums.moments_ = moments.size();
  if (moments.empty()) return sums;
  const auto part_of = [&](std::size_t i) { return static_cast<int>(i * kParts / moments.size()); };
  // The part that the middle one of a clip's moments is in: they follow each other.
  for (std::size_t begin = 0, end = 0; begin < moments.size(); begin = end) {
    while (end < moments.size() && moments[end].clip == moments[begin].clip) ++end;
    sums.part_of_clip_[moments[begin].clip] = part_of((begin + end) / 2);
  }
  const std::vector<int> sides = OtherSides(parts.marker_set.markers);
  sums.parts_.resize(kParts);
  parallel(kParts, [&](int part) {
    const auto first = [&](int p) { return (p * moments.size() + kParts - 1) / kParts; };
    SumOver(parts, moments, first(part), first(part + 1), sides, sums.parts_[part].features,
            sums.parts_[part].products);
  });
  return sums;
}

MotionPrior MotionSums::Fit(int without_part) const {
  if (parts_.empty()) return {};
  Sums sums;
  for (int part = 0; part < kParts; ++part) {
    if (part == without_part) continue;
    if (sums.features.size() == 0) {
      sums = parts_[part];
    } else {
      sums.features += parts_[part].features;
      sums.products += parts_[part].products;
    }
  }
  std::vector<Eigen::Index> moving;
  for (Eigen::Index d = 0; d < sums.features.rows(); ++d) {
    const double scatter = sums.features(d, d) / static_cast<double>(moments_);
    if (scatter > kStill * kStill) moving.push_back(d);
  }
  Eigen::MatrixXf gram = sums.features.selfadjointView<Eigen::Lower>();
  gram = gram(moving, moving).eval();
  // Sums of floats are off by about so much of their trace. Where features are as large as a fast
  // motion over kilometres, that is more than the ridge, and the solution would be anything.
  constexpr float kRounding = 1e-5F;
  gram.diagonal().array() += std::max(static_cast<float>(kPriorRidge), kRounding * gram.trace());
  const Eigen::LLT<Eigen::MatrixXf> solver(gram);
  if (solver.info() != Eigen::Success) return {};
  const Eigen::MatrixXf solved = solver.solve(sums.products(moving, Eigen::all));

  MotionPrior prior;
  prior.seconds.assign(std::begin(kHorizons), std::end(kHorizons));
  prior.weights.setZero(sums.products.rows(), sums.products.cols());
  for (std::size_t i = 0; i < moving.size(); ++i) {
    prior.weights.row(moving[i]) = solved.row(static_cast<Eigen::Index>(i));
  }
  return prior;
}

}  // namespace motiondb::core
