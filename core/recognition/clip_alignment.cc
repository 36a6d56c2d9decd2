#include "core/recognition/clip_alignment.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/motion/execution.h"
#include "core/recognition/alignment_loops.h"

namespace motiondb::core {

namespace {

constexpr double kVarianceFactor = 3;  // factor of variances: frames of other subjects differ more
constexpr double kLateStart = 2;       // cost of each strided frame before the start, if anchored
constexpr Eigen::Index kMaxStep = 2;
constexpr double kStay = 0.2;
constexpr double kNext = 0.6;
constexpr double kSkip = 0.2;
constexpr double kMinArrival = 1e-290;  // relative to the most probable frame; smaller sums are 0
constexpr float kUnreached = std::numeric_limits<float>::max();
constexpr double kMinLogRoot = -80;  // its exp is near the smallest normal float
constexpr auto kRootScale = static_cast<float>(1 / (4 * 2 * kVarianceFactor));
const double kCutOff = std::exp(4 * kMinLogRoot);
constexpr double kMaxRaisedFraction = 1e-30;
constexpr double kMinScale = 1e-150;

// Returns the sums over the paths that arrive at each frame, from the sums over the paths that end
// in each frame (after two zeros).
auto Arrivals(const Eigen::ArrayXd& ending, Eigen::Index count) {
  return kStay * ending.tail(count) + kNext * ending.segment(kMaxStep - 1, count) +
         kSkip * ending.head(count);
}

}  // namespace

void PathSum::Begin(Eigen::Index count, bool anchored) {
  count_ = count;
  begun_ = false;
  raised_fraction_ = 0;
  log_sum_ = 0;
  scale_ = 1;
  ending_.setZero(kMaxStep + count);
  next_.setZero(kMaxStep + count);
  arrival_.setOnes(count);
  if (anchored) {
    arrival_ =
        Eigen::ArrayXd::LinSpaced(count, 0, -kLateStart * static_cast<double>(count - 1)).exp();
  }
}

void PathSum::AddFrame(const Eigen::Ref<const Eigen::ArrayXf>& squared_distances) {
  if (begun_) arrival_ = Arrivals(ending_, count_);
  begun_ = true;
  // Densities are relative to the nearest reachable frame, so at least one is not zero.
  const double reached = (arrival_ > kMinArrival).select(squared_distances, kUnreached).minCoeff();
  ending_.tail(count_) =
      (arrival_ > kMinArrival)
          .select(arrival_ *
                      ((reached - squared_distances.cast<double>()) / (2 * kVarianceFactor)).exp(),
                  0.0);
  const double peak = ending_.maxCoeff();
  ending_ /= peak;
  log_sum_ += std::log(peak) - reached / (2 * kVarianceFactor);
}

void PathSum::AddRoots(const Eigen::Ref<const Eigen::ArrayXf>& roots, float nearest, bool cut_off) {
  double* const next = next_.data() + kMaxStep;
  // Sums are relative to the previous sum, so they stay in the range of doubles.
  double previous_sum = 1;
  if (begun_) {
    scale_ *= sum_;
    const double unit = 1 / sum_;
    sum_ = Advance(ending_.data(), roots.data(), static_cast<int>(count_), kStay * unit,
                   kNext * unit, kSkip * unit, next);
  } else {
    previous_sum = arrival_.sum();
    next_.tail(count_) = arrival_ * roots.cast<double>().square().square();
    sum_ = next_.sum();
  }
  begun_ = true;
  ending_.swap(next_);
  log_sum_ -= nearest / (2 * kVarianceFactor);
  if (scale_ < kMinScale) log_sum_ += std::log(std::exchange(scale_, 1));
  // An upper bound: the part from raised roots may stay constant while the sum decreases.
  raised_fraction_ = ((cut_off ? kCutOff * previous_sum : 0) + raised_fraction_) / sum_;
  if (!IsExact()) sum_ = 1;  // later results are invalid
}

bool PathSum::Roots(const Eigen::Ref<const Eigen::ArrayXf>& squared_distances, float nearest,
                    Eigen::Ref<Eigen::ArrayXf> roots) {
  const float maximum =
      core::Roots(squared_distances.data(), static_cast<int>(squared_distances.size()), nearest,
                  kRootScale, roots.data());
  return (nearest - maximum) * kRootScale < kMinLogRoot;
}

bool PathSum::IsExact() const { return raised_fraction_ < kMaxRaisedFraction; }

double PathSum::LogEvidence() const { return log_sum_ + std::log(scale_ * ending_.sum()); }

double PathSum::LogEvidenceBound(Eigen::Index count, double nearest_sum) {
  return std::log(static_cast<double>(count)) - nearest_sum / (2 * kVarianceFactor);
}

namespace {

// Returns the steps (ThrottledCancellation) of comparing a block with `count` stored frames.
std::int64_t StepsOfBlock(const MetricFrames& stored, int count) {
  return std::int64_t{count} * stored.projected.cols();
}

}  // namespace

ObservedFrames::ObservedFrames(const FrameMatrix& observed)
    : frames_(static_cast<int>(observed.rows())) {
  const int blocks = (frames_ + kFrameLanes - 1) / kFrameLanes;
  squared_norms_.setZero(blocks * kFrameLanes);
  squared_norms_.head(frames_) = observed.rowwise().squaredNorm();
  for (int block = 0; block < blocks; ++block) {
    FrameMatrix& lanes = blocks_.emplace_back(FrameMatrix::Zero(observed.cols(), kFrameLanes));
    lanes.leftCols(CountOf(block)) =
        observed.middleRows(block * kFrameLanes, CountOf(block)).transpose();
  }
}

int ObservedFrames::CountOf(int block) const {
  return std::min(kFrameLanes, frames_ - block * kFrameLanes);
}

void ObservedFrames::ComputeDistances(const MetricFrames& stored, RowRange rows, int block,
                                      Eigen::ArrayXXf& distances) const {
  const auto [first, count] = rows;
  distances.resize(count, kFrameLanes);
  SquaredDistances(stored.projected.row(first).data(), stored.squared_norms.data() + first, count,
                   static_cast<int>(stored.projected.cols()), blocks_[block].data(),
                   squared_norms_.data() + block * kFrameLanes, CountOf(block), distances.data(),
                   count);
}

void UpdateNearest(const MetricFrames& stored, RowRange rows,
                   const Eigen::Ref<const Eigen::ArrayXf>& squared_distances, float minimum,
                   NearestFrame& nearest) {
  if (!(minimum < nearest.squared_distance)) return;
  const auto at = std::find(squared_distances.begin(), squared_distances.end(), minimum) -
                  squared_distances.begin();
  nearest = {minimum, stored.rows.frame[rows.first + at]};
}

ClipAligner::ClipAligner(const FrameMatrix& observed, bool anchored)
    : observed_(observed), anchored_(anchored) {}

double ClipAligner::LogEvidenceByDistances(const MetricFrames& stored, RowRange rows,
                                           ThrottledCancellation& cancellation) {
  const int count = rows.count;
  paths_.Begin(count, anchored_);
  for (int block = 0; block < observed_.block_count(); ++block) {
    if (cancellation.cancelled(StepsOfBlock(stored, count))) return 0;
    observed_.ComputeDistances(stored, rows, block, distances_);
    for (int f = 0; f < observed_.CountOf(block); ++f) paths_.AddFrame(distances_.col(f));
  }
  return paths_.LogEvidence();
}

double ClipAligner::Align(const MetricFrames& stored, RowRange rows,
                          std::vector<NearestFrame>& nearest, const Cancelled& cancelled) {
  ThrottledCancellation cancellation(cancelled);
  const int count = rows.count;
  roots_.resize(count);
  paths_.Begin(count, anchored_);
  for (int block = 0; block < observed_.block_count(); ++block) {
    if (cancellation.cancelled(StepsOfBlock(stored, count))) return 0;
    observed_.ComputeDistances(stored, rows, block, distances_);
    for (int f = 0; f < observed_.CountOf(block); ++f) {
      const auto distances = distances_.col(f);
      const float minimum = Minimum(distances.data(), count);
      UpdateNearest(stored, rows, distances, minimum, nearest[block * kFrameLanes + f]);
      const bool cut_off = PathSum::Roots(distances, minimum, roots_);
      paths_.AddRoots(roots_, minimum, cut_off);
    }
  }
  return paths_.IsExact() ? paths_.LogEvidence()
                          : LogEvidenceByDistances(stored, rows, cancellation);
}

ClipAlignment AlignToClip(const MetricFrames& stored, RowRange rows, const FrameMatrix& observed,
                          bool anchored) {
  ClipAlignment alignment;
  alignment.nearest.assign(observed.rows(), {std::numeric_limits<float>::infinity(), 0});
  alignment.log_evidence = ClipAligner(observed, anchored).Align(stored, rows, alignment.nearest);
  return alignment;
}

}  // namespace motiondb::core
