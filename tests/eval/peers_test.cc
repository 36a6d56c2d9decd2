// Compares the peers with exhaustive search on small inputs: a weak peer would flatter the
// database.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "tests/eval/observations.h"
#include "tests/eval/peers/filling.h"
#include "tests/eval/peers/frame_distances.h"
#include "tests/eval/peers/gaussian_hmm.h"
#include "tests/eval/peers/nearest_exemplar.h"
#include "tests/eval/peers/simple_motion.h"
#include "tests/eval/peers/subsequence_dtw.h"
#include "tests/eval/peers/windowed_nearest.h"

namespace motiondb::tests::peers_test {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

core::FrameMatrix RandomFrames(int frames, int dimensions, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  return core::FrameMatrix::NullaryExpr(frames, dimensions, [&] { return normal(random); });
}

double Squares(const Eigen::RowVectorXf& stored, const Eigen::RowVectorXf& observed) {
  double sum = 0;
  for (Eigen::Index d = 0; d < stored.size(); ++d) {
    if (!std::isnan(observed[d])) sum += std::pow(stored[d] - observed[d], 2);
  }
  return sum;
}

// Returns the minimum cost of all warping paths from (i, j) to the last row, by enumeration.
double MinWarpCost(const core::FrameMatrix& costs, Eigen::Index i, Eigen::Index j, bool free_end) {
  const double here = costs(i, j);
  const bool last_row = i + 1 == costs.rows();
  const bool last_column = j + 1 == costs.cols();
  double onward = std::numeric_limits<double>::infinity();
  if (last_row && (free_end || last_column)) onward = 0;
  if (!last_row) onward = std::min(onward, MinWarpCost(costs, i + 1, j, free_end));
  if (!last_column) onward = std::min(onward, MinWarpCost(costs, i, j + 1, free_end));
  if (!last_row && !last_column) {
    onward = std::min(onward, MinWarpCost(costs, i + 1, j + 1, free_end));
  }
  return here + onward;
}

EvalClip Clip(std::string label, core::FrameMatrix states) {
  EvalClip clip{.name = label, .label = std::move(label), .source = "someone"};
  clip.states = {60, 1, std::move(states), {}};
  clip.states.root_path = core::RootPath::Zero(clip.states.states.rows(), 3);
  return clip;
}

}  // namespace

TEST_CASE("Frame distances: sums over the values present", "[eval]") {
  const core::FrameMatrix stored = RandomFrames(9, 12, 1);
  core::FrameMatrix observed = RandomFrames(5, 12, 2);
  for (const bool missing : {false, true}) {
    if (missing) {
      observed(1, 3) = kMissing;
      observed.row(2).head<6>().setConstant(kMissing);
      observed.row(4).setConstant(kMissing);
    }
    const FrameDistances distances = DistancesTo(StoredFrames(stored), observed);
    for (Eigen::Index i = 0; i < observed.rows(); ++i) {
      for (Eigen::Index j = 0; j < stored.rows(); ++j) {
        CHECK(distances.squares(i, j) ==
              Approx(Squares(stored.row(j), observed.row(i))).margin(1e-4));
      }
    }
    CHECK(distances.present[2] == (missing ? 6 : 12));
    CHECK(distances.present[4] == (missing ? 0 : 12));
  }
}

TEST_CASE("Windowed 1-NN: the minimum over all windows", "[eval]") {
  const core::FrameMatrix stored = RandomFrames(20, 6, 3);
  core::FrameMatrix window = RandomFrames(4, 6, 4);
  window(2, 1) = kMissing;
  double minimum = std::numeric_limits<double>::infinity();
  for (int start = 0; start <= 16; ++start) {
    double sum = 0;
    for (int t = 0; t < 4; ++t) sum += Squares(stored.row(start + t), window.row(t));
    minimum = std::min(minimum, sum / 23);
  }
  CHECK(NearestWindow(StoredFrames(stored), window) == Approx(minimum).epsilon(1e-4));
  CHECK(NearestWindow(StoredFrames(stored), stored.middleRows(5, 7)) < 1e-5);
}

TEST_CASE("Windowed 1-NN and DTW recognize a part of a clip as that clip", "[eval]") {
  const EvalClip walk = Clip("walk", RandomFrames(60, 12, 5));
  const EvalClip kick = Clip("kick", RandomFrames(60, 12, 6));
  const ClipSet training{&walk, &kick};
  const std::vector<std::string> labels{"kick", "walk"};
  WindowedNearest nearest(core::Scaling::kKind);
  SubsequenceDtw dtw(core::Scaling::kKind);
  for (Peer* peer : {static_cast<Peer*>(&nearest), static_cast<Peer*>(&dtw)}) {
    REQUIRE(peer->Learn(training, labels).ok());
    const auto piece = peer->Score(Slice(kick.states, 20, 24), Extent::kWindow);
    CHECK(piece[0] > piece[1]);
    CHECK(piece[0] == Approx(0).margin(1e-4));
    const auto beginning = peer->Score(Slice(walk.states, 0, 24), Extent::kPrefix);
    CHECK(beginning[1] > beginning[0]);
    CHECK(beginning[1] == Approx(0).margin(1e-4));
    const auto whole = peer->Score(walk.states, Extent::kWhole);
    CHECK(whole[1] > whole[0]);
    CHECK(whole[1] == Approx(0).margin(1e-4));
    CHECK(peer->model_bytes() == 2 * 60 * 12 * 4);
  }
}

TEST_CASE("DTW: the minimum cost of all warping paths", "[eval]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const int rows = 1 + static_cast<int>(seed % 4);
    const int columns = 1 + static_cast<int>(seed % 5);
    const core::FrameMatrix costs = RandomFrames(rows, columns, 100 + seed).cwiseAbs();
    for (const bool free_start : {false, true}) {
      for (const bool free_end : {false, true}) {
        double minimum = std::numeric_limits<double>::infinity();
        for (int start = 0; start < (free_start ? columns : 1); ++start) {
          minimum = std::min(minimum, MinWarpCost(costs, 0, start, free_end));
        }
        INFO(rows << " x " << columns << ", free start " << free_start << ", free end "
                  << free_end);
        CHECK(WarpCost(costs, {free_start, free_end}) == Approx(minimum).epsilon(1e-5));
      }
    }
  }
}

TEST_CASE("HMM: the likelihood is the sum over all state paths", "[eval]") {
  const GaussianHmm::Sequence training = RandomFrames(30, 3, 7).cast<double>();
  for (const Topology topology : {Topology::kLeftRight, Topology::kErgodic}) {
    const GaussianHmm hmm = GaussianHmm::Fit({training}, {.states = 3, .topology = topology});
    GaussianHmm::Sequence observed = RandomFrames(5, 3, 8).cast<double>();
    observed(2, 1) = std::nan("");
    const Eigen::MatrixXd emission = hmm.LogEmission(observed);
    for (const bool anywhere : {false, true}) {
      double sum = 0;
      const std::function<void(int, int, double)> go = [&](int frame, int state, double log) {
        log += emission(frame, state);
        if (frame + 1 == observed.rows()) {
          sum += std::exp(log);
          return;
        }
        for (int next = 0; next < 3; ++next) {
          go(frame + 1, next, log + hmm.log_transition()(state, next));
        }
      };
      for (int first = 0; first < 3; ++first) {
        go(0, first, anywhere ? -std::log(3.0) : hmm.log_initial()[first]);
      }
      CHECK(hmm.LogLikelihood(observed, anywhere) == Approx(std::log(sum)));
    }
  }
}

TEST_CASE("HMM: one state is one Gaussian, of the values present", "[eval]") {
  const GaussianHmm::Sequence training = RandomFrames(40, 2, 9).cast<double>();
  const GaussianHmm hmm = GaussianHmm::Fit({training}, {.states = 1, .variance_floor = 1e-6});
  Eigen::MatrixXd observed(1, 2);
  observed << 0.3, std::nan("");
  const double mean = training.col(0).mean();
  const double variance = (training.col(0).array() - mean).square().mean();
  CHECK(hmm.LogLikelihood(observed) ==
        Approx(-0.5 * std::log(2 * M_PI * variance) - std::pow(0.3 - mean, 2) / (2 * variance)));
}

TEST_CASE("HMM: Baum-Welch never lowers the likelihood, and rows still sum to 1", "[eval]") {
  for (const Topology topology : {Topology::kLeftRight, Topology::kErgodic}) {
    for (const int states : {2, 4}) {
      std::vector<GaussianHmm::Sequence> sequences;
      for (unsigned seed = 0; seed < 4; ++seed) {
        core::FrameMatrix frames = RandomFrames(25, 5, 20 + seed);
        for (int t = 0; t < 25; ++t) frames.row(t).array() += 3 * std::sin(0.3F * t);
        sequences.push_back(frames.cast<double>());
      }
      std::vector<double> likelihoods;
      const GaussianHmm hmm = GaussianHmm::Fit(
          sequences, {.states = states, .topology = topology, .max_iterations = 15, .min_gain = 0},
          &likelihoods);
      REQUIRE(likelihoods.size() > 2);
      for (std::size_t i = 1; i < likelihoods.size(); ++i) {
        CHECK(likelihoods[i] >= likelihoods[i - 1] - 1e-9 * std::abs(likelihoods[i - 1]));
      }
      for (int s = 0; s < states; ++s) {
        CHECK(hmm.log_transition().row(s).array().exp().sum() == Approx(1));
      }
      CHECK(hmm.log_initial().array().exp().sum() == Approx(1));
    }
  }
}

TEST_CASE("Simple motion: constant pose or constant velocity", "[eval]") {
  core::MarkerMotion past{{"a"}, 25, core::FrameMatrix(2, 3)};
  past.positions_m << 0, 0, 1, 0.1F, 0, 1;
  const std::vector<double> horizons{0.08, 1};
  const auto stays = SimpleMotion(0).Predict(past, horizons);
  REQUIRE(stays.ok());
  CHECK(stays->positions_m.row(1).isApprox(past.positions_m.row(1)));
  const auto goes_on = SimpleMotion(1).Predict(past, horizons);
  REQUIRE(goes_on.ok());
  CHECK(goes_on->positions_m(0, 0) == Approx(0.3));
  CHECK(goes_on->positions_m(1, 0) == Approx(2.6));
  CHECK(goes_on->positions_m(1, 2) == Approx(1));
}

TEST_CASE("Nearest exemplar: a part of a stored clip continues as stored", "[eval]") {
  EvalClip walk = Clip("walk", {});
  walk.markers = {{"a", "b"}, 25, RandomFrames(60, 6, 30)};
  EvalClip other = Clip("walk", {});
  other.markers = {{"a", "b"}, 25, RandomFrames(60, 6, 31)};
  for (const ExemplarOptions& options :
       {ExemplarOptions{1, 0, 1}, ExemplarOptions{3, 1, 1, 0.5}, ExemplarOptions{9, 3, 1}}) {
    NearestExemplar nearest;
    nearest.Learn({&walk, &other}, options);
    core::MarkerMotion past = Slice(other.markers, 10, 10);
    const auto forecast = nearest.Predict(past, {0.08, 1});
    REQUIRE(forecast.ok());
    CHECK(forecast->positions_m.row(0).isApprox(other.markers.positions_m.row(21), 1e-4F));
    CHECK(forecast->positions_m.row(1).isApprox(other.markers.positions_m.row(44), 1e-4F));
  }
}

TEST_CASE("Nearest exemplar: the difference from the exemplar's step is added and decays",
          "[eval]") {
  // Stored: one marker at rest. Observed: it moved 1 m in the last frame.
  EvalClip stored = Clip("stand", {});
  stored.markers = {{"a"}, 25, core::FrameMatrix::Zero(30, 3)};
  NearestExemplar nearest;
  nearest.Learn({&stored}, {.lags = 1, .exemplars = 1, .step_decay = 0.5});
  core::MarkerMotion past{{"a"}, 25, core::FrameMatrix::Zero(3, 3)};
  past.positions_m(2, 0) = 1;
  const auto forecast = nearest.Predict(past, {0.04, 0.08, 0.12});
  REQUIRE(forecast.ok());
  CHECK(forecast->positions_m(0, 0) == Approx(1.5));
  CHECK(forecast->positions_m(1, 0) == Approx(1.75));
  CHECK(forecast->positions_m(2, 0) == Approx(1.875));
}

TEST_CASE("Filling: linear interpolation, or the nearest stored frame", "[eval]") {
  EvalClip stored = Clip("walk", RandomFrames(40, 12, 40));
  core::StateSequence observed = Slice(stored.states, 10, 6);
  const core::FrameMatrix truth = core::WorldPositions(observed);
  observed.states.block<3, 6>(1, 0).setConstant(kMissing);
  observed.states.block<1, 6>(5, 6).setConstant(kMissing);
  const core::FrameMatrix line = FillByInterpolation(observed);
  CHECK(
      line.row(2).head<3>().isApprox((truth.row(0).head<3>() + truth.row(4).head<3>()) / 2, 1e-4F));
  CHECK(line.row(5).tail<3>().isApprox(truth.row(4).tail<3>()));
  CHECK(FillFromNearest({&stored}).Fill(observed).isApprox(truth, 1e-4F));
  observed.states.leftCols<6>().setConstant(kMissing);
  CHECK(FillByInterpolation(observed).leftCols<3>().hasNaN());
}

}  // namespace motiondb::tests::peers_test
