#include "core/inference/recognize.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/graph/generation.h"
#include "core/inference/lattice.h"
#include "core/inference/observation.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr Eigen::Index kMaxCells = 1
                                   << 26;  // frames of a window x nodes of the layer, 8 bytes each

absl::Status CheckOptions(const RecognizeOptions& options) {
  if (!(options.window_seconds > 0 && std::isfinite(options.window_seconds))) {
    return InvalidArgument("window_seconds: expected more than 0, got {}", options.window_seconds);
  }
  if (!(options.hop_seconds > 0 && std::isfinite(options.hop_seconds))) {
    return InvalidArgument("hop_seconds: expected more than 0, got {}", options.hop_seconds);
  }
  if (!(options.transition_floor >= 0 && options.transition_floor <= 1)) {
    return InvalidArgument("transition_floor: expected 0 to 1, got {}", options.transition_floor);
  }
  if (options.path_count < 1 || options.path_count > 100) {
    return InvalidArgument("path_count: expected 1 to 100, got {}", options.path_count);
  }
  return absl::OkStatus();
}

// log P_o(x | k) of every node of a layer for the frames of a window that moves along: each frame
// is computed once, however many windows and clips it serves.
class WindowEmission {
 public:
  WindowEmission(const Model& model, int layer, const FrameMatrix& observation, int frames)
      : model_(model), layer_(layer), observation_(observation) {
    log_density_.resize(frames, model.tree().node_count(layer));
  }

  // Moves to the frames [first, first + rows). Windows must come in ascending order.
  void MoveTo(int first) {
    const auto frames = static_cast<int>(log_density_.rows());
    const int keep = std::clamp(computed_ - first, 0, frames);
    for (int t = 0; t < keep; ++t) log_density_.row(t) = log_density_.row(t + first - first_);
    for (int t = keep; t < frames; ++t) {
      const float* x = observation_.row(first + t).data();
      for (Eigen::Index node = 0; node < log_density_.cols(); ++node) {
        const int branch = model_.tree().branch(layer_, static_cast<int>(node));
        log_density_(t, node) = model_.gaussians().LogDensity(branch, x);
      }
    }
    first_ = first;
    computed_ = first + frames;
  }

  const EmissionMatrix& log_density() const { return log_density_; }

  // The sum over frames of log P(x), eq. 8's denominator with P(k) uniform.
  double LogEvidence() const {
    double sum = 0;
    for (Eigen::Index t = 0; t < log_density_.rows(); ++t) {
      const double peak = log_density_.row(t).maxCoeff();
      sum += peak + std::log((log_density_.row(t).array() - peak).exp().sum());
    }
    return sum;
  }

 private:
  const Model& model_;
  const int layer_;
  const FrameMatrix& observation_;
  EmissionMatrix log_density_;
  int first_ = 0;
  int computed_ = 0;
};

double LogSumExp(const std::vector<double>& logs) {
  const double peak = *std::max_element(logs.begin(), logs.end());
  if (!std::isfinite(peak)) return peak;
  double sum = 0;
  for (double log : logs) sum += std::exp(log - peak);
  return peak + std::log(sum);
}

// log of the probability that a clip's graph generates the window, by eq. 7 with P_o for P_s.
double ClipLogGeneration(const ClipGraph& graph, const EmissionMatrix& log_density,
                         const RecognizeOptions& options) {
  const auto states = static_cast<Eigen::Index>(graph.nodes.size());
  EmissionMatrix emission(log_density.rows(), states);
  for (Eigen::Index s = 0; s < states; ++s) emission.col(s) = log_density.col(graph.nodes[s]);
  if (options.generation == Generation::kExact) {
    return LogGeneration(graph.transitions, emission, options.transition_floor);
  }
  Lattice lattice;
  for (Eigen::Index t = 0; t < emission.rows(); ++t) {
    LatticeFrame& frame = lattice.emplace_back();
    for (Eigen::Index s = 0; s < states; ++s) frame.nodes.push_back(static_cast<std::int32_t>(s));
    frame.log_emission = emission.row(t);
  }
  std::vector<double> logs{-std::numeric_limits<double>::infinity()};
  for (const NodePath& path :
       BestPaths(lattice, graph.transitions, options.transition_floor, options.path_count)) {
    logs.push_back(path.log_probability);
  }
  return LogSumExp(logs);
}

// P(label | window): labels alike beforehand, and the clips of a label too. Uniform where no clip
// can generate the window.
std::vector<LabelScore> ScoreLabels(const Model& model, const std::vector<ClipScore>& clips) {
  std::map<std::string, std::vector<double>> logs;
  for (const ClipScore& score : clips) {
    logs[model.clips()[score.clip].label].push_back(score.log_probability);
  }
  std::vector<LabelScore> labels;
  std::vector<double> evidence;
  for (const auto& [label, of_clips] : logs) {
    evidence.push_back(LogSumExp(of_clips) - std::log(static_cast<double>(of_clips.size())));
    labels.push_back({label, 0});
  }
  const double all = LogSumExp(evidence);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    labels[i].probability =
        std::isfinite(all) ? std::exp(evidence[i] - all) : 1 / static_cast<double>(labels.size());
  }
  std::stable_sort(labels.begin(), labels.end(), [](const LabelScore& a, const LabelScore& b) {
    return a.probability > b.probability;
  });
  return labels;
}

}  // namespace

absl::StatusOr<std::vector<RecognizedWindow>> Recognize(const Model& model,
                                                        const StateSequence& observation,
                                                        const RecognizeOptions& options,
                                                        const Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(CheckOptions(options));
  MOTIONDB_ASSIGN_OR_RETURN(const int layer, model.ResolveLayer(options.layer));
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, observation));

  const double rate = observation.frame_rate_hz;
  const int frames = observation.frame_count();
  const auto in_frames = [&](double seconds) {
    return static_cast<int>(
        std::clamp(std::round(seconds * rate), 1.0, static_cast<double>(frames)));
  };
  const int width = options.whole ? frames : in_frames(options.window_seconds);
  const int hop = in_frames(options.hop_seconds);
  if (static_cast<Eigen::Index>(width) * model.tree().node_count(layer) > kMaxCells) {
    return InvalidArgument(
        "window_seconds: a window of {} frames over the {} nodes of layer {} would take too much "
        "memory; ask for shorter windows or a higher layer",
        width, model.tree().node_count(layer), layer);
  }

  WindowEmission emission(model, layer, scaled, width);
  std::vector<RecognizedWindow> windows;
  for (int first = 0; first + width <= frames; first += hop) {
    emission.MoveTo(first);
    const double evidence = emission.LogEvidence();
    RecognizedWindow& window = windows.emplace_back();
    window.start_seconds = first / rate;
    window.end_seconds = (first + width) / rate;
    window.layer = layer;
    const auto& graphs = model.clip_graphs(layer);
    for (int clip = 0; clip < static_cast<int>(graphs.size()); ++clip) {
      if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
      window.clips.push_back(
          {clip, ClipLogGeneration(graphs[clip], emission.log_density(), options) - evidence});
    }
    window.labels = ScoreLabels(model, window.clips);
    std::stable_sort(window.clips.begin(), window.clips.end(),
                     [](const ClipScore& a, const ClipScore& b) {
                       return a.log_probability > b.log_probability;
                     });
    window.familiarity = model.familiarity().Rank(
        layer, FamiliarityScore(model.global_graph(layer), emission.log_density()));
  }
  return windows;
}

}  // namespace motiondb::core
