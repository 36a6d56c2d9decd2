#include "tests/eval/peers/gaussian_hmm.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace motiondb::tests {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNever = -std::numeric_limits<double>::infinity();

// A term this far below the maximum is lost in rounding, so its exponential is skipped.
constexpr double kLostInRounding = -40;

// Log-sum-exp of a row or column. Allocates nothing: Baum-Welch spends most of its time here.
template <typename Logs>
double LogSum(const Logs& logs) {
  const double peak = logs.maxCoeff();
  if (!std::isfinite(peak)) return peak;
  double sum = 0;
  for (Index i = 0; i < logs.size(); ++i) {
    const double term = logs(i) - peak;
    if (term > kLostInRounding) sum += std::exp(term);
  }
  return peak + std::log(sum);
}

// Returns log P(x_1 .. x_t, state at t): frames x states.
MatrixXd Forward(const VectorXd& log_initial, const MatrixXd& log_transition,
                 const MatrixXd& emission) {
  MatrixXd alpha(emission.rows(), emission.cols());
  alpha.row(0) = log_initial.transpose() + emission.row(0);
  for (Index t = 1; t < emission.rows(); ++t) {
    for (Index s = 0; s < emission.cols(); ++s) {
      alpha(t, s) = LogSum(alpha.row(t - 1).transpose() + log_transition.col(s)) + emission(t, s);
    }
  }
  return alpha;
}

// Returns log P(x_t+1 .. x_T | state at t): frames x states.
MatrixXd Backward(const MatrixXd& log_transition, const MatrixXd& emission) {
  MatrixXd beta = MatrixXd::Zero(emission.rows(), emission.cols());
  for (Index t = emission.rows() - 2; t >= 0; --t) {
    for (Index s = 0; s < emission.cols(); ++s) {
      beta(t, s) = LogSum(log_transition.row(s) + emission.row(t + 1) + beta.row(t + 1));
    }
  }
  return beta;
}

MatrixXd Stack(const std::vector<MatrixXd>& sequences) {
  Index frames = 0;
  for (const MatrixXd& sequence : sequences) frames += sequence.rows();
  MatrixXd all(frames, sequences.front().cols());
  Index at = 0;
  for (const MatrixXd& sequence : sequences) {
    all.middleRows(at, sequence.rows()) = sequence;
    at += sequence.rows();
  }
  return all;
}

// Splits each sequence into equal parts: frames x states, one 1 per row.
MatrixXd EqualParts(const std::vector<MatrixXd>& sequences, int states) {
  std::vector<MatrixXd> weights;
  for (const MatrixXd& sequence : sequences) {
    MatrixXd& part = weights.emplace_back(MatrixXd::Zero(sequence.rows(), states));
    for (Index t = 0; t < sequence.rows(); ++t) part(t, t * states / sequence.rows()) = 1;
  }
  return Stack(weights);
}

// k-means, initialized with the frame nearest the mean and then repeatedly the frame furthest from
// the chosen ones.
MatrixXd Clusters(const MatrixXd& frames, int states) {
  constexpr int kRounds = 10;
  MatrixXd centres(states, frames.cols());
  Index next = 0;
  (frames.rowwise() - frames.colwise().mean()).rowwise().squaredNorm().minCoeff(&next);
  VectorXd nearest = VectorXd::Constant(frames.rows(), std::numeric_limits<double>::infinity());
  for (int s = 0; s < states; ++s) {
    centres.row(s) = frames.row(next);
    nearest = nearest.cwiseMin((frames.rowwise() - centres.row(s)).rowwise().squaredNorm());
    nearest.maxCoeff(&next);
  }
  MatrixXd weights;
  for (int round = 0; round < kRounds; ++round) {
    weights = MatrixXd::Zero(frames.rows(), states);
    for (Index t = 0; t < frames.rows(); ++t) {
      Index s = 0;
      (centres.rowwise() - frames.row(t)).rowwise().squaredNorm().minCoeff(&s);
      weights(t, s) = 1;
    }
    for (int s = 0; s < states; ++s) {
      const double count = weights.col(s).sum();
      if (count > 0) centres.row(s) = weights.col(s).transpose() * frames / count;
    }
  }
  return weights;
}

}  // namespace

MatrixXd GaussianHmm::LogEmission(const Sequence& sequence) const {
  const MatrixXd precision = variances_.cwiseInverse();
  const MatrixXd pull = means_.cwiseProduct(precision);
  const MatrixXd constant =
      means_.cwiseProduct(pull).array() + (2 * std::numbers::pi * variances_.array()).log();
  const auto quadratic = [&](const MatrixXd& x) {
    MatrixXd sum = x.cwiseAbs2() * precision.transpose();
    sum.noalias() -= 2 * x * pull.transpose();
    return sum;
  };
  if (!sequence.hasNaN()) {
    return -0.5 * (quadratic(sequence).rowwise() + constant.rowwise().sum().transpose());
  }
  const MatrixXd present = sequence.unaryExpr([](double x) { return std::isnan(x) ? 0.0 : 1.0; });
  const MatrixXd x = sequence.unaryExpr([](double v) { return std::isnan(v) ? 0.0 : v; });
  return -0.5 * (quadratic(x) + present * constant.transpose());
}

double GaussianHmm::LogLikelihood(const Sequence& sequence, bool anywhere) const {
  const Index states = log_initial_.size();
  const VectorXd initial =
      anywhere ? VectorXd(VectorXd::Constant(states, -std::log(static_cast<double>(states))))
               : log_initial_;
  const MatrixXd alpha = Forward(initial, log_transition_, LogEmission(sequence));
  return LogSum(alpha.row(alpha.rows() - 1));
}

void GaussianHmm::SetGaussians(const MatrixXd& weights, const MatrixXd& frames, double floor) {
  const MatrixXd sums = weights.transpose() * frames;
  const MatrixXd squares = weights.transpose() * frames.cwiseAbs2();
  for (Index s = 0; s < weights.cols(); ++s) {
    const double weight = weights.col(s).sum();
    if (weight < 1e-9) continue;  // keeps the parameters of an empty state
    means_.row(s) = sums.row(s) / weight;
    variances_.row(s) = (squares.row(s) / weight - means_.row(s).cwiseAbs2()).cwiseMax(floor);
  }
}

GaussianHmm GaussianHmm::Fit(const std::vector<Sequence>& sequences, const HmmOptions& options,
                             std::vector<double>* likelihoods) {
  const MatrixXd frames = Stack(sequences);
  const Eigen::RowVectorXd mean = frames.colwise().mean();
  const Eigen::RowVectorXd variance =
      (frames.rowwise() - mean).cwiseAbs2().colwise().mean().cwiseMax(options.variance_floor);
  const Index states = options.states;

  GaussianHmm hmm;
  hmm.means_ = mean.replicate(states, 1);
  hmm.variances_ = variance.replicate(states, 1);
  hmm.log_transition_ = MatrixXd::Constant(states, states, kNever);
  if (options.topology == Topology::kLeftRight) {
    hmm.log_initial_ = VectorXd::Constant(states, kNever);
    hmm.log_initial_[0] = 0;
    for (Index s = 0; s + 1 < states; ++s) {
      hmm.log_transition_(s, s) = hmm.log_transition_(s, s + 1) = std::log(0.5);
    }
    hmm.log_transition_(states - 1, states - 1) = 0;
    hmm.SetGaussians(EqualParts(sequences, options.states), frames, options.variance_floor);
  } else {
    const double elsewhere = 0.1 / std::max(1.0, static_cast<double>(states - 1));
    hmm.log_initial_ = VectorXd::Constant(states, -std::log(static_cast<double>(states)));
    hmm.log_transition_.setConstant(std::log(elsewhere));
    hmm.log_transition_.diagonal().setConstant(states == 1 ? 0 : std::log(0.9));
    hmm.SetGaussians(Clusters(frames, options.states), frames, options.variance_floor);
  }

  double before = kNever;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    double likelihood = 0;
    MatrixXd weights(frames.rows(), states);
    VectorXd initial = VectorXd::Zero(states);
    MatrixXd transition = MatrixXd::Zero(states, states);
    Index at = 0;
    const MatrixXd all_emission = hmm.LogEmission(frames);
    for (const Sequence& sequence : sequences) {
      const MatrixXd emission = all_emission.middleRows(at, sequence.rows());
      const MatrixXd alpha = Forward(hmm.log_initial_, hmm.log_transition_, emission);
      const MatrixXd beta = Backward(hmm.log_transition_, emission);
      const double all = LogSum(alpha.row(alpha.rows() - 1));
      likelihood += all;
      weights.middleRows(at, sequence.rows()) = (alpha + beta).array() - all;
      weights.middleRows(at, sequence.rows()) =
          weights.middleRows(at, sequence.rows()).array().exp().matrix().eval();
      initial += weights.row(at).transpose();
      for (Index t = 0; t + 1 < sequence.rows(); ++t) {
        const Eigen::RowVectorXd onward = emission.row(t + 1) + beta.row(t + 1);
        transition +=
            ((hmm.log_transition_.colwise() + alpha.row(t).transpose()).rowwise() + onward)
                .unaryExpr([all](double log) {
                  return log - all > kLostInRounding ? std::exp(log - all) : 0.0;
                });
      }
      at += sequence.rows();
    }
    if (likelihoods != nullptr) likelihoods->push_back(likelihood);
    if (likelihood - before < options.min_gain * static_cast<double>(frames.rows())) break;
    before = likelihood;

    hmm.log_initial_ = (initial / initial.sum()).array().log();
    for (Index s = 0; s < states; ++s) {
      const double leaving = transition.row(s).sum();
      if (leaving > 0) hmm.log_transition_.row(s) = (transition.row(s) / leaving).array().log();
    }
    hmm.SetGaussians(weights, frames, options.variance_floor);
  }
  return hmm;
}

double GaussianHmm::parameter_count() const {
  return static_cast<double>(log_initial_.size() + log_transition_.size() + means_.size() +
                             variances_.size());
}

}  // namespace motiondb::tests
