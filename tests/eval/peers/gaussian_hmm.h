// A hidden Markov model with a diagonal Gaussian in each state, trained by Baum-Welch in log space.
// Immutable once fitted.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace motiondb::tests {

enum class Topology {
  kLeftRight,  // starts in the first state; stays or moves to the next
  kErgodic,    // any state may follow any state
};

struct HmmOptions {
  int states = 4;
  Topology topology = Topology::kLeftRight;
  double variance_floor = 0.1;  // minimum variance of a dimension
  int max_iterations = 20;
  double min_gain = 1e-3;  // of the log likelihood per frame; stops if an iteration gains less
};

class GaussianHmm {
 public:
  // frames x dimensions. NaN is a missing number, ignored by the likelihood.
  using Sequence = Eigen::MatrixXd;

  // Fits whole sequences without NaN. Starts from equal parts of each sequence (left-right) or from
  // k-means (ergodic). Deterministic. Writes the log likelihood before each iteration to
  // `likelihoods`, if given.
  static GaussianHmm Fit(const std::vector<Sequence>& sequences, const HmmOptions& options,
                         std::vector<double>* likelihoods = nullptr);

  // Returns log P(sequence), natural, summed over all state paths. With `anywhere` the sequence is
  // a part of a motion: all initial states are equally probable.
  double LogLikelihood(const Sequence& sequence, bool anywhere = false) const;

  // Returns the log density of each frame in each state: frames x states.
  Eigen::MatrixXd LogEmission(const Sequence& sequence) const;

  const Eigen::VectorXd& log_initial() const { return log_initial_; }
  const Eigen::MatrixXd& log_transition() const { return log_transition_; }
  double parameter_count() const;

 private:
  void SetGaussians(const Eigen::MatrixXd& weights, const Eigen::MatrixXd& frames, double floor);

  Eigen::VectorXd log_initial_;
  Eigen::MatrixXd log_transition_;  // from x to
  Eigen::MatrixXd means_;           // states x dimensions
  Eigen::MatrixXd variances_;
};

}  // namespace motiondb::tests
