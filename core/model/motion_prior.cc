#include "core/model/motion_prior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/model/model.h"
#include "core/motion/mirror.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr double kHorizons[] = {0.08, 0.16, 0.32,
                                0.4,  0.56, 1.0};  // s, the default horizons of a query
constexpr int kMaxMoments = 2500;
constexpr double kMinMomentDistance = 0.04;  // s; nearer moments add little information
constexpr Eigen::Index kFeatureRows = 128;   // in one matrix product
// Leg lengths squared. Independent of the number of moments. The error hardly changes from 1 to 10.
constexpr double kPriorRidge = 2.8;
constexpr float kMinFeature = 1e-4F;  // smaller features are excluded

struct Moment {
  int clip = 0;
  int frame = 0;
};

std::vector<Moment> Moments(const ModelParts& parts) {
  const double rate = parts.settings.frame_rate_hz;
  const auto past = static_cast<int>(std::ceil(kLags * kLagSeconds * rate - 1e-6));
  const auto future = static_cast<int>(std::ceil(std::end(kHorizons)[-1] * rate - 1e-6));
  const int step = std::max(1, static_cast<int>(std::lround(kMinMomentDistance * rate)));
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
  for (const int i : SpreadEvenly(std::ssize(all), kMaxMoments)) spread.push_back(all[i]);
  return spread;
}

// Features and futures of a moment, one row each.
struct MomentRow {
  Eigen::RowVectorXf features;
  Eigen::RowVectorXf futures;
};

MomentRow RowOf(const ModelParts& parts, const Moment& moment) {
  const auto horizons = static_cast<Eigen::Index>(std::size(kHorizons));
  const Track track(parts, moment.clip);
  const FrameMatrix history = HistoryAt(track, moment.frame);
  FrameMatrix future(horizons, history.cols());
  for (Eigen::Index h = 0; h < horizons; ++h) {
    future.row(h) =
        track.SeenFrom(moment.frame, kHorizons[h] * track.frame_rate_hz()) - history.row(0);
  }
  return {MotionFeatures(history), future.reshaped<Eigen::RowMajor>().transpose()};
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

MirrorBasis::MirrorBasis(const std::vector<int>& other_sides, int marker_count)
    : numbers_(3 * marker_count) {
  const float kHalf = std::sqrt(0.5F);
  for (int marker = 0; marker < marker_count; ++marker) {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Index here = 3 * marker + axis;
      if (other_sides.empty()) {
        terms_[kEven].push_back({here, here, 1, 0});
        continue;
      }
      const float sign = axis == 1 ? -1.0F : 1.0F;  // y points to the left
      const Eigen::Index there = 3 * other_sides[marker] + axis;
      if (here == there) {
        terms_[sign > 0 ? kEven : kOdd].push_back({here, here, 1, 0});
      } else if (here < there) {
        terms_[kEven].push_back({here, there, kHalf, sign * kHalf});
        terms_[kOdd].push_back({here, there, kHalf, -sign * kHalf});
      }
    }
  }
}

void MirrorBasis::Take(Half half, const Eigen::Ref<const Eigen::RowVectorXf>& poses,
                       Eigen::Ref<Eigen::RowVectorXf> parts) const {
  Eigen::Index to = 0;
  for (Eigen::Index pose = 0; pose < poses.size(); pose += numbers_) {
    for (const Term& term : terms_[half]) {
      parts[to++] = term.a * poses[pose + term.first] + term.b * poses[pose + term.second];
    }
  }
}

void MirrorBasis::AddRule(Half half, const FrameMatrix& rule, FrameMatrix& weights) const {
  const std::vector<Term>& terms = terms_[half];
  if (terms.empty()) return;
  const auto expand = [&](const auto& add, Eigen::Index parts) {
    for (Eigen::Index p = 0; p < parts; ++p) {
      const Term& term = terms[p % std::ssize(terms)];
      const Eigen::Index pose = p / std::ssize(terms) * numbers_;
      add(p, pose + term.first, term.a);
      if (term.b != 0) add(p, pose + term.second, term.b);
    }
  };
  FrameMatrix to_poses = FrameMatrix::Zero(rule.rows(), weights.cols());
  for (Eigen::Index row = 0; row < rule.rows(); ++row) {
    expand([&](Eigen::Index p, Eigen::Index to,
               float factor) { to_poses(row, to) += factor * rule(row, p); },
           rule.cols());
  }
  expand([&](Eigen::Index p, Eigen::Index to,
             float factor) { weights.row(to) += factor * to_poses.row(p); },
         rule.rows());
}

MotionSums MotionSums::Over(const ModelParts& parts, const ParallelFor& parallel) {
  const int markers = parts.marker_set.marker_count();
  const std::vector<int> sides = OtherSides(parts.marker_set.markers);
  MotionSums sums(MirrorBasis(sides, markers));
  sums.part_of_clip_.assign(parts.clips.size(), 0);
  const std::vector<Moment> moments = Moments(parts);
  sums.moments_ = moments.size();
  if (moments.empty()) return sums;
  const auto part_of = [&](std::size_t i) { return static_cast<int>(i * kParts / moments.size()); };
  // A clip is in the part of its middle moment, because its moments are consecutive.
  for (std::size_t begin = 0, end = 0; begin < moments.size(); begin = end) {
    while (end < moments.size() && moments[end].clip == moments[begin].clip) ++end;
    sums.part_of_clip_[moments[begin].clip] = part_of((begin + end) / 2);
  }
  sums.parts_.resize(kParts);
  const auto horizons = static_cast<Eigen::Index>(std::size(kHorizons));
  // A mirror image has the same products within the even half and within the odd half.
  const float images = sides.empty() ? 1 : 2;
  parallel(kParts, [&](int part) {
    const auto first = [&](int p) { return (p * moments.size() + kParts - 1) / kParts; };
    FrameMatrix x[2];
    FrameMatrix y[2];
    for (const auto half : {MirrorBasis::kEven, MirrorBasis::kOdd}) {
      const Eigen::Index size = sums.basis_.size(half);
      x[half].resize(kFeatureRows, (1 + kLags) * size);
      y[half].resize(kFeatureRows, horizons * size);
      sums.parts_[part].halves[half].features.setZero(x[half].cols(), x[half].cols());
      sums.parts_[part].halves[half].products.setZero(x[half].cols(), y[half].cols());
    }
    for (std::size_t i = first(part); i < first(part + 1); i += kFeatureRows) {
      const auto rows =
          static_cast<Eigen::Index>(std::min<std::size_t>(kFeatureRows, first(part + 1) - i));
      for (Eigen::Index row = 0; row < rows; ++row) {
        const MomentRow moment = RowOf(parts, moments[i + row]);
        for (const auto half : {MirrorBasis::kEven, MirrorBasis::kOdd}) {
          sums.basis_.Take(half, moment.features, x[half].row(row));
          sums.basis_.Take(half, moment.futures, y[half].row(row));
        }
      }
      for (const auto half : {MirrorBasis::kEven, MirrorBasis::kOdd}) {
        if (sums.basis_.size(half) == 0) continue;
        Sums& of_half = sums.parts_[part].halves[half];
        const auto features = x[half].topRows(rows).transpose();
        of_half.features.selfadjointView<Eigen::Lower>().rankUpdate(features, images);
        of_half.products.noalias() += images * features * y[half].topRows(rows);
      }
    }
  });
  return sums;
}

MotionSums::Sums MotionSums::Total(MirrorBasis::Half half, int without_part) const {
  Sums total;
  for (int part = 0; part < kParts; ++part) {
    if (part == without_part) continue;
    const Sums& of_part = parts_[part].halves[half];
    if (total.features.size() == 0) {
      total = of_part;
    } else {
      total.features += of_part.features;
      total.products += of_part.products;
    }
  }
  return total;
}

MotionPrior MotionSums::Fit(int without_part) const {
  if (parts_.empty()) return {};
  const Sums totals[2] = {Total(MirrorBasis::kEven, without_part),
                          Total(MirrorBasis::kOdd, without_part)};
  // Relative rounding error of sums of floats. For very large features (a fast motion over
  // kilometres) it exceeds the ridge, and the solution would be arbitrary.
  constexpr float kRounding = 1e-5F;
  float trace = 0;
  for (const Sums& sums : totals) trace += sums.features.trace();
  const float ridge = std::max(static_cast<float>(kPriorRidge), kRounding * trace);

  MotionPrior prior;
  const Eigen::Index numbers = basis_.size(MirrorBasis::kEven) + basis_.size(MirrorBasis::kOdd);
  const auto horizons = static_cast<Eigen::Index>(std::size(kHorizons));
  prior.weights.setZero((1 + kLags) * numbers, horizons * numbers);
  for (const auto half : {MirrorBasis::kEven, MirrorBasis::kOdd}) {
    const Sums& sums = totals[half];
    std::vector<Eigen::Index> moving;
    for (Eigen::Index d = 0; d < sums.features.rows(); ++d) {
      const double scatter = sums.features(d, d) / static_cast<double>(moments_);
      if (scatter > kMinFeature * kMinFeature) moving.push_back(d);
    }
    if (moving.empty()) continue;
    Eigen::MatrixXf gram = sums.features.selfadjointView<Eigen::Lower>();
    gram = gram(moving, moving).eval();
    gram.diagonal().array() += ridge;
    const Eigen::LLT<Eigen::MatrixXf> solver(gram);
    if (solver.info() != Eigen::Success) return {};
    const Eigen::MatrixXf solved = solver.solve(sums.products(moving, Eigen::all));
    FrameMatrix rule = FrameMatrix::Zero(sums.products.rows(), sums.products.cols());
    for (std::size_t i = 0; i < moving.size(); ++i) {
      rule.row(moving[i]) = solved.row(static_cast<Eigen::Index>(i));
    }
    basis_.AddRule(half, rule, prior.weights);
  }
  prior.seconds.assign(std::begin(kHorizons), std::end(kHorizons));
  return prior;
}

}  // namespace motiondb::core
