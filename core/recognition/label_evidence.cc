#include "core/recognition/label_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/inference/log_sum.h"

namespace motiondb::core {
namespace {

// Probabilities proportional to exp(logs), most probable first.
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

std::vector<double> LabelEvidence(const Model& model, const std::vector<std::string>& labels,
                                  const std::vector<ClipEvidence>& clips) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::vector<double> evidence(labels.size(), kNone);
  double poorest = -kNone;
  for (const ClipEvidence& clip : clips) {
    const auto label =
        std::lower_bound(labels.begin(), labels.end(), model.clips()[clip.clip].label);
    double& of_label = evidence[static_cast<std::size_t>(label - labels.begin())];
    of_label = std::max(of_label, clip.log_evidence);
    poorest = std::min(poorest, clip.log_evidence);
  }
  std::replace(evidence.begin(), evidence.end(), kNone, poorest);
  return evidence;
}

std::vector<LabelScore> LabelsByAlignment(const Model& model,
                                          const std::vector<std::string>& labels,
                                          const WindowAlignment& alignment,
                                          const EvidenceWeight& weight) {
  std::vector<double> logs = LabelEvidence(model, labels, alignment.clips);
  for (double& log : logs) log *= weight.At(alignment.frames);
  return Normalized(labels, logs);
}

}  // namespace motiondb::core
