#include "core/prediction/forecast.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/inference/observation.h"
#include "core/model/clip_mask.h"
#include "core/model/model.h"
#include "core/model/pose_history.h"
#include "core/motion/error.h"
#include "core/motion/execution.h"
#include "core/motion/mirror.h"

namespace motiondb::core {

namespace {

// Chosen like the constants of pose_history.cc. The error hardly changes near these values.
constexpr std::size_t kExamples = 64;
constexpr int kMoments = 256;   // candidates, compared by their history; also 256 mirror images
constexpr int kMinPool = 2048;  // stored frames to choose from, if the model has enough
constexpr double kKernelLength = 0.59;  // leg lengths
constexpr double kNoise = 0.03;
constexpr int kSpeedLags = 3;

Track TrackOf(const Model& model, int frame) {
  return Track(model.parts(), model.clip_of_frame(frame));
}

// Returns the mirror image of a key or of features: rows of 3 N_v numbers, one after another.
Eigen::RowVectorXf MirrorRows(const Model& model, const Eigen::RowVectorXf& rows) {
  const std::vector<int>& other_sides = model.other_sides();
  const auto numbers = 3 * std::ssize(other_sides);
  Eigen::RowVectorXf mirrored(rows.size());
  for (Eigen::Index first = 0; first < rows.size(); first += numbers) {
    float* to = mirrored.data() + first;
    for (const int other : other_sides) {
      const float* const from = rows.data() + first + 3 * other;
      *to++ = from[0];
      *to++ = -from[1];
      *to++ = from[2];
    }
  }
  return mirrored;
}

double MeanLength(const Eigen::RowVectorXf& vectors) {
  return vectors.reshaped<Eigen::RowMajor>(vectors.size() / 3, 3).rowwise().norm().mean();
}

}  // namespace

Forecaster::Forecaster(const Model& model, const StateSequence& past,
                       std::vector<StoredMoment> moments, const MotionPrior* prior)
    : model_(model),
      prior_(prior == nullptr ? model.prior() : *prior),
      history_(HistoryAt(Track(past), past.frame_count() - 1)),
      key_(HistoryKey(history_)),
      features_(MotionFeatures(history_)),
      speed_(MeanLength(history_.row(0) - history_.row(kSpeedLags))) {
  std::vector<Eigen::RowVectorXf> keys;
  std::vector<float> distances;
  for (const StoredMoment& moment : moments) {
    Eigen::RowVectorXf key = HistoryKeyAt(TrackOf(model_, moment.frame), moment.frame);
    if (moment.mirrored) key = MirrorRows(model_, key);
    distances.push_back((key - key_).squaredNorm());
    keys.push_back(std::move(key));
  }
  std::vector<std::size_t> order(moments.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return distances[a] < distances[b]; });
  for (const std::size_t i : order) {
    moments_.push_back(moments[i]);
    keys_.push_back(std::move(keys[i]));
  }
  features_of_.resize(moments_.size());
}

const Eigen::RowVectorXf& Forecaster::FeaturesOf(std::size_t i) {
  Eigen::RowVectorXf& features = features_of_[i];
  if (features.size() == 0) {
    const StoredMoment& moment = moments_[i];
    features = MotionFeatures(HistoryAt(TrackOf(model_, moment.frame), moment.frame));
    if (moment.mirrored) features = MirrorRows(model_, features);
  }
  return features;
}

void Forecaster::ChooseExamples(double seconds) {
  std::vector<std::size_t> chosen;
  const double frames = seconds * model_.settings().frame_rate_hz;
  const auto past =
      static_cast<int>(std::ceil(kLags * kLagSeconds * model_.settings().frame_rate_hz));
  for (std::size_t i = 0; i < moments_.size() && chosen.size() < kExamples; ++i) {
    const int frame = moments_[i].frame;
    const ModelClip& clip = model_.clips()[model_.clip_of_frame(frame)];
    const int last = clip.first_frame + clip.frame_count - 1;
    if (frame + frames > last + 1e-6) continue;
    if (clip.HasGlitch(frame - past, frame + static_cast<int>(std::ceil(frames)))) continue;
    chosen.push_back(i);
  }
  if (chosen == chosen_) return;
  chosen_ = std::move(chosen);
  FrameMatrix keys(static_cast<Eigen::Index>(chosen_.size()), key_.size());
  for (std::size_t e = 0; e < chosen_.size(); ++e) {
    keys.row(static_cast<Eigen::Index>(e)) = keys_[chosen_[e]];
  }
  weights_ =
      chosen_.empty() ? ExemplarWeights() : WeighExemplars(keys, key_, kKernelLength, kNoise);
}

Eigen::RowVectorXf Forecaster::Future(const StoredMoment& moment, double seconds) const {
  const Track track = TrackOf(model_, moment.frame);
  const Eigen::RowVectorXf moved = track.SeenFrom(moment.frame, seconds * track.frame_rate_hz()) -
                                   track.SeenFrom(moment.frame, 0);
  return moment.mirrored ? MirrorRows(model_, moved) : moved;
}

Forecast Forecaster::At(double seconds) {
  ChooseExamples(seconds);
  // The Gaussian process predicts the error of the prior: the difference between an example's
  // displacement and the prior's prediction for it.
  Eigen::RowVectorXf displacement = Eigen::RowVectorXf::Zero(history_.cols());
  Eigen::RowVectorXf features = features_;
  std::vector<Eigen::RowVectorXf> futures;
  for (std::size_t e = 0; e < chosen_.size(); ++e) {
    const auto weight = static_cast<float>(weights_.weights[static_cast<Eigen::Index>(e)]);
    futures.push_back(Future(moments_[chosen_[e]], seconds));
    displacement += weight * futures.back();
    features -= weight * FeaturesOf(chosen_[e]);
  }
  displacement += prior_.Displacement(features, seconds);

  Forecast forecast;
  forecast.evidence = {.variance = weights_.variance, .speed = speed_};
  forecast.has_examples = !chosen_.empty();
  double total = 0;
  for (std::size_t e = 0; e < chosen_.size(); ++e) {
    const double weight = weights_.weights[static_cast<Eigen::Index>(e)];
    if (weight <= 0) continue;
    total += weight;
    forecast.evidence.spread += weight * MeanLength(futures[e] - displacement);
  }
  if (total > 0) forecast.evidence.spread /= total;
  forecast.positions = model_.rigid_tree().Restore(history_.row(0) + displacement, history_.row(0));
  return forecast;
}

absl::StatusOr<std::vector<StoredMoment>> FindMoments(const Model& model, const StateSequence& past,
                                                      double transition_floor,
                                                      std::shared_ptr<const ClipMask> mask,
                                                      FrameRange without,
                                                      const Cancelled& cancelled,
                                                      std::vector<NodeState> known) {
  std::vector<StoredMoment> moments;
  const auto find = [&](const StateSequence& seen, bool mirrored) -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, seen));
    std::vector<NodeState> now = mirrored ? std::vector<NodeState>() : std::move(known);
    if (now.empty()) {
      MOTIONDB_ASSIGN_OR_RETURN(
          const PathSearch search,
          FindNodePaths(model, scaled, {.transition_floor = transition_floor, .mask = mask},
                        cancelled));
      MOTIONDB_ASSIGN_OR_RETURN(now, LastNodes(model, search, transition_floor, cancelled));
    }
    const std::vector<int> pool =
        ExemplarPool(model, model.layer_count(), now, mask.get(), kMinPool);
    for (const Exemplar& exemplar : NearestFrames(model, pool, scaled.row(scaled.rows() - 1).data(),
                                                  kMoments, mask.get(), without)) {
      moments.push_back({exemplar.frame, mirrored});
    }
    return absl::OkStatus();
  };
  MOTIONDB_RETURN_IF_ERROR(find(past, false));
  if (model.other_sides().empty()) return moments;
  StateSequence mirrored = past;
  mirrored.states = MirrorStates(model.other_sides(), past.states);
  MOTIONDB_RETURN_IF_ERROR(find(mirrored, true));
  return moments;
}

ExemplarWeights WeighExemplars(const FrameMatrix& keys, const Eigen::RowVectorXf& query,
                               double kernel_length, double noise) {
  const Eigen::VectorXd squares = keys.rowwise().squaredNorm().cast<double>();
  const Eigen::MatrixXd dots = (keys * keys.transpose()).cast<double>();
  const Eigen::Index count = keys.rows();
  Eigen::MatrixXd kernel(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double distance = std::sqrt(std::max(0.0, squares[i] + squares[j] - 2 * dots(i, j)));
      kernel(i, j) = std::exp(-distance / kernel_length);
    }
    kernel(i, i) = 1 + noise;
  }
  const Eigen::VectorXd to_query =
      ((keys.rowwise() - query).rowwise().norm().cast<double>().array() / -kernel_length).exp();
  ExemplarWeights result;
  result.weights = kernel.selfadjointView<Eigen::Lower>().llt().solve(to_query);
  result.variance = 1 - to_query.dot(result.weights);
  return result;
}

NodeForecaster::NodeForecaster(const Model& model, int layer, const std::vector<NodeState>& now,
                               const ClipMask* mask)
    : model_(model),
      layer_(layer),
      graph_(AllowedGraph(model, layer, mask)),
      probability_(static_cast<std::size_t>(model.tree().node_count(layer)), 0.0) {
  for (const NodeState& state : now) probability_[state.node] = state.probability;
}

Eigen::RowVectorXf NodeForecaster::Mean() const {
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(model_.states().cols());
  for (std::size_t node = 0; node < probability_.size(); ++node) {
    if (probability_[node] <= 0) continue;
    const int branch = model_.tree().branch(layer_, static_cast<int>(node));
    mean += probability_[node] * model_.gaussians().means().row(branch).cast<double>();
  }
  return mean.cast<float>().cwiseProduct(model_.scale().divisor);
}

void NodeForecaster::Step() {
  const Eigen::RowVectorXf mean = Mean();
  const Landmarks& hips = model_.marker_set().landmarks;
  const Eigen::RowVector2f velocity =
      (mean.segment<2>(6 * hips.left_hip + 3) + mean.segment<2>(6 * hips.right_hip + 3)) / 2;
  moved_ += velocity.transpose() / static_cast<float>(model_.settings().frame_rate_hz);
  std::vector<double> next(probability_.size(), 0.0);
  double total = 0;
  for (std::size_t node = 0; node < probability_.size(); ++node) {
    const auto leaving = static_cast<double>(graph_.row_sum(static_cast<int>(node)));
    if (probability_[node] <= 0 || leaving <= 0) continue;
    for (const Edge& edge : graph_.row(static_cast<int>(node))) {
      next[edge.to] += probability_[node] * edge.count / leaving;
    }
    total += probability_[node];
  }
  if (total <= 0) return;
  for (double& p : next) p /= total;
  probability_ = std::move(next);
}

Eigen::RowVectorXf NodeForecaster::At(double seconds, const Cancelled& cancelled) {
  const auto frames = static_cast<int>(std::lround(seconds * model_.settings().frame_rate_hz));
  ThrottledCancellation cancellation(cancelled);
  const auto step = std::ssize(probability_) + graph_.edge_count();
  for (; frames_ < frames && !cancellation.cancelled(step); ++frames_) Step();
  const Eigen::RowVectorXf mean = Mean();
  Eigen::RowVectorXf positions(mean.size() / 2);
  for (Eigen::Index m = 0; m < positions.size() / 3; ++m) {
    positions.segment<3>(3 * m) = mean.segment<3>(6 * m);
    positions.segment<2>(3 * m) += moved_.transpose();
  }
  return positions;
}

}  // namespace motiondb::core
