// A hidden Markov model with a diagonal Gaussian in each state, learned by Baum-Welch in log space.
// Immutable once fitted; safe to share between threads.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace motiondb::tests {

enum class Topology {
  kLeftRight,  // begins in the first state; stays or goes on to the next
  kErgodic,    // any state may follow any
};

struct HmmOptions {
  int states = 4;
  Topology topology = Topology::kLeftRight;
  double variance_floor = 0.1;  // least variance of a dimension
  int max_iterations = 20;
  double least_gain = 1e-3;  // of the log likelihood a frame; stops when an iteration gains less
};

class GaussianHmm {
 public:
  // frames x dimensions. NaN is a missing number and is left out of the likelihood.
  using Sequence = Eigen::MatrixXd;

  // From whole sequences without NaN. Begins with each sequence cut into as many equal parts as
  // there are states (left-right), or with k-means from frames far apart (ergodic): the same input
  // gives the same model. `likelihoods`, where given, receives the log likelihood before each
  // iteration.
  static GaussianHmm Fit(const std::vector<Sequence>& sequences, const HmmOptions& options,
                         std::vector<double>* likelihoods = nullptr);

  // log P(sequence), natural, summed over all state paths. With `anywhere` the sequence is a part
  // of a motion and may begin in any state alike.
  double LogLikelihood(const Sequence& sequence, bool anywhere = false) const;

  // log density of each frame in each state: frames x states.
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
