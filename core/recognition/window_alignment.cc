#include "core/recognition/window_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/inference/lattice.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/noise_energy.h"
#include "core/recognition/shortlist.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {

namespace {

constexpr double kMinDifference = 1e-12;  // avoids log(0) if a frame is compared with itself

double FamiliarityScore(const Model& model, const MetricObservation& observation,
                        const std::vector<int>& compared,
                        const std::vector<NearestFrame>& nearest) {
  FrameMatrix differences(static_cast<Eigen::Index>(compared.size()), observation.states.cols());
  for (std::size_t i = 0; i < compared.size(); ++i) {
    const auto state = observation.states.row(compared[i]);
    differences.row(static_cast<Eigen::Index>(i)) =
        state - NearestState(model, nearest[i].frame, state);
  }
  const FrameMatrix whitened = RowProduct(differences, observation.MetricFor(model).whitening);
  return FamiliarityOfDifference(static_cast<double>(whitened.squaredNorm()) /
                                 static_cast<double>(whitened.size()));
}

// Returns the strided frames of one clip, projected with `metric`.
MetricFrames ProjectClip(const Model& model, const MotionMetric& metric, int clip) {
  const StridedFrames& all = model.metric_frames().rows;
  MetricFrames frames;
  frames.rows.frame.assign(all.frame.begin() + all.begin[clip],
                           all.frame.begin() + all.begin[clip + 1]);
  frames.rows.begin = {0, all.count(clip)};
  frames.projected = SharedRows(Project(metric, model.states()(frames.rows.frame, Eigen::all)));
  frames.squared_norms = frames.projected.view().rowwise().squaredNorm();
  return frames;
}

}  // namespace

Eigen::RowVectorXf NearestState(const Model& model, int nearest,
                                const Eigen::Ref<const Eigen::RowVectorXf>& state) {
  const int reach = FrameStride(model.settings().frame_rate_hz) - 1;
  const ModelClip& clip = model.clips()[model.clip_of_frame(nearest)];
  const int first = clip.first_frame;
  const int last = clip.first_frame + clip.frame_count - 1;
  int best = nearest;
  float least = std::numeric_limits<float>::infinity();
  for (int frame = std::max(first, nearest - reach); frame <= std::min(last, nearest + reach);
       ++frame) {
    const float squared = (model.states().row(frame) - state).squaredNorm();
    if (squared >= least) continue;
    least = squared;
    best = frame;
  }
  const Eigen::RowVectorXf at_best = model.states().row(best);
  Eigen::RowVectorXf closest = at_best;
  for (const int next : {best - 1, best + 1}) {
    if (next < first || next > last) continue;
    const Eigen::RowVectorXf step = model.states().row(next) - at_best;
    const float length = step.squaredNorm();
    if (!(length > 0)) continue;
    const float share = std::clamp(step.dot(state - at_best) / length, 0.0F, 1.0F);
    const Eigen::RowVectorXf between = at_best + share * step;
    const float squared = (between - state).squaredNorm();
    if (squared >= least) continue;
    least = squared;
    closest = between;
  }
  return closest;
}

double FamiliarityOfDifference(double mean_square) {
  return -std::log(std::max(mean_square, kMinDifference));
}

void SortByEvidence(std::vector<ClipEvidence>& clips) {
  std::stable_sort(clips.begin(), clips.end(), [](const ClipEvidence& a, const ClipEvidence& b) {
    return a.log_evidence > b.log_evidence;
  });
}

absl::StatusOr<WindowAlignment> AlignWindow(const Model& model,
                                            const MetricObservation& observation,
                                            const std::vector<int>& compared,
                                            const std::vector<bool>& left_out, bool anchored,
                                            const Cancelled& cancelled) {
  const FrameMatrix observed = observation.projected(compared, Eigen::all);
  std::vector<NearestFrame> nearest(compared.size(), {std::numeric_limits<float>::infinity(), 0});
  ClipAligner aligner(observed, anchored);
  WindowAlignment window;
  window.frames = static_cast<int>(compared.size());
  window.energy = observed.rowwise().squaredNorm().mean();
  window.noise = NoiseEnergy(
      observation.projected.middleRows(compared.front(), compared.back() - compared.front()));
  for (const int clip : ShortlistClips(model, observation.own.get(), observed, left_out)) {
    const double log_evidence =
        observation.own == nullptr
            ? aligner.Align(model.metric_frames(), clip, nearest, cancelled)
            : aligner.Align(ProjectClip(model, *observation.own, clip), 0, nearest, cancelled);
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    window.clips.push_back({clip, log_evidence});
  }
  SortByEvidence(window.clips);
  window.familiarity_score = FamiliarityScore(model, observation, compared, nearest);
  return window;
}

namespace {

// Returns probabilities proportional to exp(logs), most probable first.
std::vector<LabelScore> Normalized(const std::vector<std::string>& labels,
                                   const std::vector<double>& logs) {
  const double all = LogSum(logs);
  std::vector<LabelScore> scores;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    scores.push_back({labels[i], std::isfinite(all) ? std::exp(logs[i] - all)
                                                    : 1 / static_cast<double>(labels.size())});
  }
  std::stable_sort(scores.begin(), scores.end(), [](const LabelScore& a, const LabelScore& b) {
    return a.probability > b.probability;
  });
  return scores;
}

}  // namespace

std::vector<LabelScore> LabelsByGeneration(const Model& model,
                                           const std::vector<ClipScore>& clips) {
  std::map<std::string, std::vector<double>> logs;
  for (const ClipScore& score : clips) {
    logs[model.clips()[score.clip].label].push_back(score.log_probability);
  }
  std::vector<std::string> labels;
  std::vector<double> evidence;
  for (const auto& [label, of_clips] : logs) {
    labels.push_back(label);
    evidence.push_back(LogSum(of_clips) - std::log(static_cast<double>(of_clips.size())));
  }
  return Normalized(labels, evidence);
}

std::vector<std::string> Labels(const Model& model) {
  std::set<std::string> labels;
  for (const ModelClip& clip : model.clips()) labels.insert(clip.label);
  return {labels.begin(), labels.end()};
}

std::size_t LabelIndex(const Model& model, const std::vector<std::string>& labels, int clip) {
  const auto at = std::ranges::lower_bound(labels, model.clips()[clip].label);
  return static_cast<std::size_t>(at - labels.begin());
}

std::vector<double> LabelEvidence(const Model& model, const std::vector<std::string>& labels,
                                  const std::vector<ClipEvidence>& clips) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::vector<double> evidence(labels.size(), kNone);
  double lowest = -kNone;
  for (const ClipEvidence& clip : clips) {
    double& of_label = evidence[LabelIndex(model, labels, clip.clip)];
    of_label = std::max(of_label, clip.log_evidence);
    lowest = std::min(lowest, clip.log_evidence);
  }
  std::replace(evidence.begin(), evidence.end(), kNone, lowest);
  return evidence;
}

std::vector<LabelScore> LabelsByAlignment(const std::vector<std::string>& labels,
                                          std::vector<double> evidence, double weight) {
  for (double& log : evidence) log *= weight;
  return Normalized(labels, evidence);
}

}  // namespace motiondb::core
