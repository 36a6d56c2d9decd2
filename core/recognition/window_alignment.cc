#include "core/recognition/window_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string_view>

#include "core/inference/lattice.h"
#include "core/model/label_units.h"
#include "core/model/model.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/metric_observation.h"
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

MetricFrames ProjectStridedRows(const Model& model, const MotionMetric& metric, RowRange rows) {
  const auto first = model.metric_frames().rows.frame.begin() + rows.first;
  MetricFrames frames;
  frames.rows.frame.assign(first, first + rows.count);
  frames.rows.begin = {0, rows.count};
  frames.projected = SharedRows(Project(metric, model.states()(frames.rows.frame, Eigen::all)));
  frames.squared_norms = frames.projected.view().rowwise().squaredNorm();
  return frames;
}

void SortByEvidence(std::vector<UnitEvidence>& units) {
  std::stable_sort(units.begin(), units.end(), [](const UnitEvidence& a, const UnitEvidence& b) {
    return a.log_evidence > b.log_evidence;
  });
}

absl::StatusOr<WindowAlignment> AlignWindow(const Model& model, const LabelUnits& units,
                                            const MetricObservation& observation,
                                            const std::vector<int>& compared, const ClipMask* mask,
                                            bool anchored, const Cancelled& cancelled,
                                            int left_out_label) {
  const FrameMatrix observed = observation.projected(compared, Eigen::all);
  std::vector<NearestFrame> nearest(compared.size(), {std::numeric_limits<float>::infinity(), 0});
  ClipAligner aligner(observed, anchored);
  WindowAlignment window;
  window.frames = static_cast<int>(compared.size());
  window.noise = NoiseEnergy(
      observation.projected.middleRows(compared.front(), compared.back() - compared.front()));
  for (const int clip : ShortlistClips(model, observation.own.get(), observed, mask)) {
    for (const LabelUnit& unit : units.of_clip(clip)) {
      if (unit.label >= 0 && unit.label == left_out_label) continue;
      const double log_evidence =
          observation.own == nullptr
              ? aligner.Align(model.metric_frames(), unit.rows, nearest, cancelled)
              : aligner.Align(ProjectStridedRows(model, *observation.own, unit.rows),
                              {0, unit.rows.count}, nearest, cancelled);
      if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
      window.units.push_back({&unit, log_evidence});
    }
  }
  SortByEvidence(window.units);
  window.familiarity_score = FamiliarityScore(model, observation, compared, nearest);
  return window;
}

namespace {

void SortByProbability(std::vector<LabelScore>& scores) {
  std::stable_sort(scores.begin(), scores.end(), [](const LabelScore& a, const LabelScore& b) {
    return a.probability > b.probability;
  });
}

// Returns probabilities proportional to exp(logs), most probable first.
std::vector<LabelScore> Normalized(const std::vector<std::string>& labels,
                                   const std::vector<double>& logs) {
  std::vector<LabelScore> scores;
  if (labels.empty()) return scores;
  const double all = LogSum(logs);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    scores.push_back({labels[i], std::isfinite(all) ? std::exp(logs[i] - all)
                                                    : 1 / static_cast<double>(labels.size())});
  }
  SortByProbability(scores);
  return scores;
}

}  // namespace

std::vector<ClipScore> ClipsOf(const LabelUnits& units, const std::vector<UnitEvidence>& evidence) {
  std::vector<ClipScore> clips;
  std::set<int> listed;
  for (const auto& [unit, log_evidence] : evidence) {
    if (!listed.insert(unit->clip).second) continue;
    clips.push_back({unit->clip, log_evidence, units.NameOf(unit->label)});
  }
  return clips;
}

std::vector<LabelScore> LabelsByGeneration(const std::vector<std::string>& labels,
                                           const std::vector<UnitEvidence>& units) {
  std::vector<std::vector<double>> logs(labels.size());
  for (const auto& [unit, log_probability] : units) {
    if (unit->label >= 0) logs[unit->label].push_back(log_probability);
  }
  std::vector<double> evidence;
  for (const std::vector<double>& of_units : logs) {
    evidence.push_back(LogSum(of_units) - std::log(static_cast<double>(of_units.size())));
  }
  return Normalized(labels, evidence);
}

std::vector<double> LabelEvidence(std::size_t label_count, const std::vector<UnitEvidence>& units) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::vector<double> evidence(label_count, kNone);
  double lowest = -kNone;
  for (const auto& [unit, log_evidence] : units) {
    if (unit->label >= 0) {
      evidence[unit->label] = std::max(evidence[unit->label], log_evidence);
    }
    lowest = std::min(lowest, log_evidence);
  }
  std::replace(evidence.begin(), evidence.end(), kNone, lowest);
  return evidence;
}

std::vector<LabelScore> LabelsByAlignment(const std::vector<std::string>& labels,
                                          std::vector<double> evidence, double weight) {
  for (double& log : evidence) log *= weight;
  return Normalized(labels, evidence);
}

std::vector<TrackAnswer> OtherTracks(const Model& model, const LabelUnits& units,
                                     const std::vector<UnitEvidence>& evidence, double weight,
                                     double known) {
  std::vector<TrackAnswer> answers;
  if (units.other_tracks().empty()) return answers;
  std::vector<double> logs;
  for (const UnitEvidence& unit : evidence) logs.push_back(weight * unit.log_evidence);
  const double all = LogSum(logs);
  for (const std::string& track : units.other_tracks()) {
    std::map<std::string_view, double> probabilities;
    for (std::size_t u = 0; u < evidence.size() && std::isfinite(all); ++u) {
      const LabelUnit& unit = *evidence[u].unit;
      const ModelClip& clip = model.clips()[unit.clip];
      const int first = unit.first_frame - clip.first_frame;
      for (const LabelSpan& span : clip.labels.Of(track)) {
        const int shared = std::min(first + unit.frame_count, span.first_frame + span.frame_count) -
                           std::max(first, span.first_frame);
        if (shared <= 0) continue;
        probabilities[span.label] += known * std::exp(logs[u] - all) * shared / unit.frame_count;
      }
    }
    TrackAnswer& answer = answers.emplace_back();
    answer.track = track;
    answer.none = 1;
    for (const auto& [label, probability] : probabilities) {
      answer.labels.push_back({std::string(label), probability});
      answer.none -= probability;
    }
    answer.none = std::max(0.0, answer.none);
    SortByProbability(answer.labels);
  }
  return answers;
}

}  // namespace motiondb::core
