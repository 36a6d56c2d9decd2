#include "core/estimation/estimate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/inference/observation.h"
#include "core/model/model.h"
#include "core/motion/error.h"

namespace motiondb::core {

namespace {

// Tuned on motion of other people and behaviours than the stored ones (stored: database 1;
// observed: walks of database 2 and five kinds of HDM05 motion). Lengths are leg lengths.
constexpr int kExemplars = 64;
constexpr int kGroups = 4;              // of markers, left out together
constexpr double kNoise = 0.08;         // difference between bodies at a seen marker
constexpr double kScatter = 0.01;       // minimum error of the regression
constexpr double kAnchorSeconds = 0.5;  // maximum time to a frame that sees the marker
constexpr double kErrorSeconds = 0.4;   // correlation time of the regression's error
constexpr double kMinSurprise = 1.5;
constexpr double kAcceleration = 15;  // per s^2, not followed by linear interpolation
constexpr double kStraight = 0.003;   // minimum error of linear interpolation

// Correlation of the regression's errors over a time difference.
double ErrorCorrelation(double seconds) { return std::exp(-seconds / kErrorSeconds); }

// Estimated position of a marker in the frame's reference frame, leg lengths.
struct Guess {
  Eigen::Vector3d position;
  double variance = 0;  // of the distance to the true position
};

// Errors of the regression on markers that are seen.
struct Trial {
  Eigen::MatrixX3d errors;  // markers x 3
  double surprise = 1;      // mean squared error over expected squared error
};

// A frame near a gap that sees the marker.
struct Anchor {
  int frame = 0;
  Eigen::Vector3d error;  // of the regression in that frame
};

class Filler {
 public:
  Filler(const Model& model, const StateSequence& observation, const FrameMatrix& scaled, int layer,
         const std::vector<std::int32_t>& nodes, const ClipMask* mask)
      : model_(model),
        observation_(observation),
        scaled_(scaled),
        layer_(layer),
        nodes_(nodes),
        mask_(mask) {}

  // Frames must come in ascending order.
  FilledFrame Fill(int frame) {
    // Frames before the reach of anchors are no longer needed.
    exemplars_.erase(exemplars_.begin(), exemplars_.lower_bound(frame - Reach()));
    trials_.erase(trials_.begin(), trials_.lower_bound(frame - Reach()));
    FilledFrame filled{.frame = frame};
    StateSequence pose{observation_.frame_rate_hz, observation_.leg_length_m,
                       observation_.states.row(frame), observation_.root_path.row(frame)};
    pose.floor_m = observation_.floor_m;
    filled.deviations_m.setZero(marker_count());
    const std::vector<int> missing = Missing(frame);
    const std::vector<Guess> guesses = Regression(frame, missing);
    for (std::size_t i = 0; i < missing.size(); ++i) {
      const int marker = missing[i];
      const Guess guess = Anchored(frame, marker, guesses[i]);
      pose.states.row(0).segment<3>(6 * marker) = guess.position.cast<float>().transpose();
      filled.deviations_m[marker] =
          static_cast<float>(std::sqrt(guess.variance) * observation_.leg_length_m);
    }
    filled.marker_positions_m = WorldPositions(pose).row(0);
    return filled;
  }

  std::vector<int> Missing(int frame) const {
    std::vector<int> missing;
    for (int m = 0; m < marker_count(); ++m) {
      if (!Sees(frame, m)) missing.push_back(m);
    }
    return missing;
  }

 private:
  int marker_count() const { return static_cast<int>(observation_.states.cols()) / 6; }

  int Reach() const { return static_cast<int>(kAnchorSeconds * observation_.frame_rate_hz); }

  bool Sees(int frame, int marker) const {
    return !observation_.states.row(frame).segment<3>(6 * marker).hasNaN();
  }

  const std::vector<Exemplar>& Exemplars(int frame) {
    auto [known, is_new] = exemplars_.try_emplace(frame);
    if (is_new) {
      known->second =
          NearestFrames(model_, ExemplarPool(model_, layer_, {{nodes_[frame], 1.0}}, mask_),
                        scaled_.row(frame).data(), kExemplars, mask_);
    }
    return known->second;
  }

  // Returns the positions of `markers`, from all other markers seen in the frame.
  std::vector<Guess> Regression(int frame, const std::vector<int>& markers) {
    if (markers.empty()) return {};
    std::vector<int> seen;
    for (int m = 0; m < marker_count(); ++m) {
      if (Sees(frame, m) && !std::binary_search(markers.begin(), markers.end(), m)) {
        seen.push_back(m);
      }
    }
    const std::vector<Exemplar>& exemplars = Exemplars(frame);
    const auto count = static_cast<Eigen::Index>(exemplars.size());
    Eigen::VectorXd weights(count);
    Eigen::MatrixXd known(count, 3 * static_cast<Eigen::Index>(seen.size()));
    Eigen::MatrixXd wanted(count, 3 * static_cast<Eigen::Index>(markers.size()));
    for (Eigen::Index e = 0; e < count; ++e) {
      weights[e] = exemplars[e].weight;
      const auto copy = [&](const std::vector<int>& from, auto&& from_start) {
        for (std::size_t i = 0; i < from.size(); ++i) {
          from_start.template segment<3>(3 * static_cast<Eigen::Index>(i)) =
              model_.states()
                  .row(exemplars[e].frame)
                  .segment<3>(6 * from[i])
                  .cwiseProduct(model_.scale().divisor.segment<3>(6 * from[i]))
                  .cast<double>();
        }
      };
      copy(seen, known.row(e));
      copy(markers, wanted.row(e));
    }
    Eigen::VectorXd at(known.cols());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      at.segment<3>(3 * static_cast<Eigen::Index>(i)) = Seen(frame, seen[i]);
    }
    const Regressed regressed = Regress(known, wanted, weights, at, kNoise * kNoise);
    std::vector<Guess> guesses;
    for (std::size_t i = 0; i < markers.size(); ++i) {
      const auto first = 3 * static_cast<Eigen::Index>(i);
      guesses.push_back({regressed.mean.segment<3>(first),
                         regressed.variance.segment<3>(first).sum() + kScatter * kScatter});
    }
    return guesses;
  }

  Eigen::Vector3d Seen(int frame, int marker) const {
    return observation_.states.row(frame).segment<3>(6 * marker).cast<double>().transpose();
  }

  // Tests the regression on the markers seen in a frame, leaving out one group of markers at a
  // time.
  const Trial& TestRegression(int frame) {
    auto [known, is_new] = trials_.try_emplace(frame);
    if (!is_new) return known->second;
    Trial& trial = known->second;
    trial.errors.setZero(marker_count(), 3);
    double squares = 0;
    double expected = 0;
    for (int group = 0; group < kGroups; ++group) {
      std::vector<int> markers;
      for (int m = group; m < marker_count(); m += kGroups) {
        if (Sees(frame, m)) markers.push_back(m);
      }
      const std::vector<Guess> guesses = Regression(frame, markers);
      for (std::size_t i = 0; i < markers.size(); ++i) {
        trial.errors.row(markers[i]) = (Seen(frame, markers[i]) - guesses[i].position).transpose();
        squares += trial.errors.row(markers[i]).squaredNorm();
        expected += guesses[i].variance;
      }
    }
    if (expected > 0) trial.surprise = squares / expected;
    return trial;
  }

  // Returns the nearest frame in one direction, within reach, that sees the marker.
  std::optional<Anchor> FindAnchor(int frame, int marker, int direction) {
    for (int t = frame + direction;
         std::abs(t - frame) <= Reach() && t >= 0 && t < observation_.frame_count();
         t += direction) {
      if (!Sees(t, marker)) continue;
      return Anchor{t, TestRegression(t).errors.row(marker).transpose()};
    }
    return std::nullopt;
  }

  // Corrects the guess by the errors at the anchors, by their correlation with the error here (a
  // Gaussian process over time).
  Guess Anchored(int frame, int marker, Guess guess) {
    const auto before = FindAnchor(frame, marker, -1);
    const auto after = FindAnchor(frame, marker, 1);
    const auto apart = [&](int a, int b) { return (a - b) / observation_.frame_rate_hz; };
    const double to_before = before ? ErrorCorrelation(apart(frame, before->frame)) : 0;
    const double to_after = after ? ErrorCorrelation(apart(after->frame, frame)) : 0;
    const double between =
        before && after ? ErrorCorrelation(apart(after->frame, before->frame)) : 0;
    const double settled = 1 - between * between;
    const double share_before = (to_before - between * to_after) / settled;
    const double share_after = (to_after - between * to_before) / settled;
    if (before) guess.position += share_before * before->error;
    if (after) guess.position += share_after * after->error;
    // A body unlike the stored ones has large errors on seen markers too.
    guess.variance *= std::max(kMinSurprise, TestRegression(frame).surprise);
    guess.variance *= std::max(0.0, 1 - share_before * to_before - share_after * to_after);
    if (!(before && after)) return guess;
    // Combine with linear interpolation, which is accurate over short gaps.
    const double from_start = apart(frame, before->frame);
    const double to_end = apart(after->frame, frame);
    const Eigen::Vector3d straight =
        (to_end * Seen(before->frame, marker) + from_start * Seen(after->frame, marker)) /
        (from_start + to_end);
    const double off = kAcceleration * from_start * to_end / 2;
    const double straight_variance = off * off + kStraight * kStraight;
    const double share = guess.variance / (guess.variance + straight_variance);
    guess.position += share * (straight - guess.position);
    guess.variance *= 1 - share;
    return guess;
  }

  const Model& model_;
  const StateSequence& observation_;
  const FrameMatrix& scaled_;
  const int layer_;
  const std::vector<std::int32_t>& nodes_;
  const ClipMask* const mask_;
  std::map<int, std::vector<Exemplar>> exemplars_;
  std::map<int, Trial> trials_;
};

}  // namespace

absl::StatusOr<std::vector<FilledFrame>> FillMissing(const Model& model,
                                                     const StateSequence& observation,
                                                     const FrameMatrix& scaled, int layer,
                                                     const std::vector<std::int32_t>& nodes,
                                                     Fill fill, const ClipMask* mask,
                                                     const Cancelled& cancelled) {
  Filler filler(model, observation, scaled, layer, nodes, mask);
  std::vector<FilledFrame> filled;
  const int last = observation.frame_count() - 1;
  for (int t = fill == Fill::kEveryFrame ? 0 : last; t <= last; ++t) {
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    if (!filler.Missing(t).empty()) filled.push_back(filler.Fill(t));
  }
  return filled;
}

void ApplyFilled(const std::vector<FilledFrame>& filled, StateSequence& observation) {
  for (const FilledFrame& frame : filled) {
    const auto root = observation.root_path.row(frame.frame);
    const double c = std::cos(root[2]);
    const double s = std::sin(root[2]);
    for (Eigen::Index m = 0; m < frame.deviations_m.size(); ++m) {
      if (frame.deviations_m[m] == 0) continue;
      const Eigen::Vector3d at = frame.marker_positions_m.segment<3>(3 * m).cast<double>();
      const double x = at.x() - root[0];
      const double y = at.y() - root[1];
      observation.states.row(frame.frame).segment<3>(6 * m) =
          (Eigen::RowVector3d(c * x + s * y, -s * x + c * y, at.z()) / observation.leg_length_m)
              .cast<float>();
    }
  }
}

Regressed Regress(const Eigen::MatrixXd& known, const Eigen::MatrixXd& wanted,
                  const Eigen::VectorXd& weights, const Eigen::VectorXd& at,
                  double noise_variance) {
  const Eigen::VectorXd root = weights.cwiseSqrt();
  const Eigen::RowVectorXd known_mean = weights.transpose() * known;
  const Eigen::RowVectorXd wanted_mean = weights.transpose() * wanted;
  const Eigen::MatrixXd x = root.asDiagonal() * (known.rowwise() - known_mean);
  const Eigen::MatrixXd y = root.asDiagonal() * (wanted.rowwise() - wanted_mean);

  // Dual form: there are fewer examples than values.
  const Eigen::MatrixXd shared = x * x.transpose();
  Eigen::MatrixXd kernel = shared;
  kernel.diagonal().array() += noise_variance;
  const Eigen::LLT<Eigen::MatrixXd> solver(kernel);
  const Eigen::VectorXd beside = x * (at - known_mean.transpose());
  const Eigen::VectorXd share = solver.solve(beside);
  const Eigen::MatrixXd solved = solver.solve(y);

  Regressed regressed;
  regressed.mean = wanted_mean.transpose() + y.transpose() * share;
  // Residual variance of the examples, corrected for the degrees of freedom of the fit and for
  // leverage.
  const double examples = 1 / weights.squaredNorm();
  const double used = std::min(solver.solve(shared).trace() + 1, 0.9 * examples);
  const double leverage = 1 / examples + share.cwiseAbs2().dot(weights);
  regressed.variance = (1 + leverage) * examples / (examples - used) * noise_variance *
                       y.cwiseProduct(solved).colwise().sum().transpose();
  return regressed;
}

absl::StatusOr<Estimation> Estimate(const Model& model, const StateSequence& observation,
                                    const EstimateOptions& options, const Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, observation));
  MOTIONDB_ASSIGN_OR_RETURN(PathSearch search,
                            FindNodePaths(model, scaled, options.search, cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(const auto last,
                            LastNodes(model, search, options.search.transition_floor, cancelled));

  Estimation estimation;
  estimation.layer = search.layer;
  estimation.paths = std::move(search.paths);
  const int node = estimation.paths.front().nodes.back();
  const auto found = std::ranges::find(last, node, &NodeState::node);
  estimation.state = {node, found == last.end() ? 0 : found->probability};
  MOTIONDB_ASSIGN_OR_RETURN(
      estimation.filled,
      FillMissing(model, observation, scaled, search.layer, estimation.paths.front().nodes,
                  options.fill, options.search.mask.get(), cancelled));
  return estimation;
}

}  // namespace motiondb::core
