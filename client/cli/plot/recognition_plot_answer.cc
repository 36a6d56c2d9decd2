#include "client/cli/plot/recognition_plot_answer.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "client/cli/database_text.h"
#include "client/cli/query/recognition_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {

namespace {

double Probability(double value) { return std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 0; }

// The best clip of a window, if it has a path.
const v1::ClipProbability* BestClip(const v1::RecognitionWindow& window) {
  if (window.clips_size() == 0 || !std::isfinite(window.clips(0).log_probability())) return nullptr;
  return &window.clips(0);
}

std::vector<PlotLabel> LabelsOf(const std::vector<const v1::RecognitionWindow*>& windows,
                                double unknown_threshold) {
  std::map<std::string, PlotLabel> found;
  for (const v1::RecognitionWindow* window : windows) {
    for (const v1::LabelProbability& label : window->labels()) {
      found[LabelOrPlaceholder(label.label())].probability += Probability(label.probability());
    }
    if (window->labels_size() > 0 && !IsUnknown(*window, unknown_threshold)) {
      ++found[LabelOrPlaceholder(window->labels(0).label())].windows_won;
    }
    if (const v1::ClipProbability* clip = BestClip(*window)) {
      found.try_emplace(LabelOrPlaceholder(clip->label()));  // for the colour of the clip
    }
  }
  return SortedLabels(found);
}

std::map<std::string, int> ClipIndices(const std::vector<const v1::RecognitionWindow*>& windows,
                                       const std::map<std::string, int>& label_indices,
                                       std::vector<AnswerClip>& clips) {
  std::map<std::string, AnswerClip> found;
  for (const v1::RecognitionWindow* window : windows) {
    const v1::ClipProbability* best = BestClip(*window);
    if (best == nullptr) continue;
    AnswerClip& clip = found[best->clip()];
    clip.name = ShortName(best->clip());
    clip.label = label_indices.at(LabelOrPlaceholder(best->label()));
    ++clip.windows_won;
  }
  std::vector<std::pair<std::string, AnswerClip>> ranked(found.begin(), found.end());
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return a.second.windows_won > b.second.windows_won;
  });
  std::map<std::string, int> indices;
  for (auto& [name, clip] : ranked) {
    indices.emplace(name, static_cast<int>(clips.size()));
    clips.push_back(std::move(clip));
  }
  return indices;
}

// Returns the line of the text answer: "walk 0.93, jog 0.05, unknown 0.02; familiarity 0.95; best
// clip 07_01".
std::string TooltipOf(const v1::RecognitionWindow& window) {
  constexpr int kShownLabels = 3;
  std::string text = fmt::format("{:.2f}-{:.2f} s: ", window.start_seconds(), window.end_seconds());
  for (int i = 0; i < std::min(window.labels_size(), kShownLabels); ++i) {
    const auto& label = window.labels(i);
    text += fmt::format("{}{} {:.2f}", i > 0 ? ", " : "", LabelOrPlaceholder(label.label()),
                        label.probability());
  }
  if (window.labels_size() == 0) text += "no labels";
  if (window.has_unknown_probability()) {
    text += ", " + UnknownText(window.unknown_probability());
  }
  text += fmt::format("; familiarity {:.2f}", window.familiarity());
  if (const auto* clip = BestClip(window)) text += "; best clip " + ShortName(clip->clip());
  return text;
}

AnswerColumn ColumnOf(const v1::RecognitionWindow& window, const WindowCell& cell,
                      double unknown_threshold, const std::map<std::string, int>& label_indices,
                      const std::map<std::string, int>& clip_indices) {
  AnswerColumn column;
  column.cell = cell;
  column.probabilities.resize(label_indices.size());
  column.unknown = window.has_unknown_probability() ? Probability(window.unknown_probability()) : 0;
  double sum = column.unknown;
  for (const v1::LabelProbability& label : window.labels()) {
    const double probability = Probability(label.probability());
    const int index = label_indices.at(LabelOrPlaceholder(label.label()));
    column.probabilities[static_cast<std::size_t>(index)] += probability;
    sum += probability;
  }
  if (sum > 1) {
    for (double& probability : column.probabilities) probability /= sum;
    column.unknown /= sum;
  }
  column.familiarity = std::isfinite(window.familiarity())
                           ? std::clamp(window.familiarity(), 0.0, 1.0)
                           : std::numeric_limits<double>::quiet_NaN();
  if (IsUnknown(window, unknown_threshold)) {
    column.answer = AnswerColumn::kUnknown;
  } else if (window.labels_size() > 0) {
    column.answer = label_indices.at(LabelOrPlaceholder(window.labels(0).label()));
  }
  if (const auto* clip = BestClip(window)) column.clip = clip_indices.at(clip->clip());
  column.tooltip = TooltipOf(window);
  return column;
}

// Returns the value that most columns have, the first of equals.
int MostCommon(const std::vector<AnswerColumn>& columns, int AnswerColumn::*value) {
  std::map<int, int> counts;
  int best = AnswerColumn::kNone, most = 0;
  for (const AnswerColumn& column : columns) most = std::max(most, ++counts[column.*value]);
  for (auto column = columns.rbegin(); column != columns.rend(); ++column) {
    if (counts[(*column).*value] == most) best = (*column).*value;
  }
  return best;
}

AnswerColumn MeanOf(const std::vector<AnswerColumn>& columns) {
  if (columns.size() == 1) return columns.front();
  AnswerColumn mean = columns.front();
  mean.cell.end = columns.back().cell.end;
  mean.cell.middle = (mean.cell.start + mean.cell.end) / 2;
  const auto count = static_cast<double>(columns.size());
  std::size_t familiar_count = 0;
  double familiarity = 0, unknown = 0;
  std::vector<double> sums(mean.probabilities.size());
  for (const AnswerColumn& column : columns) {
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += column.probabilities[i];
    unknown += column.unknown;
    if (!std::isfinite(column.familiarity)) continue;
    familiarity += column.familiarity;
    ++familiar_count;
  }
  for (std::size_t i = 0; i < sums.size(); ++i) mean.probabilities[i] = sums[i] / count;
  mean.unknown = unknown / count;
  if (familiar_count > 0) mean.familiarity = familiarity / static_cast<double>(familiar_count);
  mean.answer = MostCommon(columns, &AnswerColumn::answer);
  mean.clip = MostCommon(columns, &AnswerColumn::clip);
  mean.tooltip = fmt::format("first of {}: {}", CountText(columns.size(), "window"), mean.tooltip);
  return mean;
}

}  // namespace

RecognitionAnswer RecognitionAnswerFrom(const v1::RecognizeResponse& response,
                                        double unknown_threshold) {
  constexpr std::size_t kMaxColumns = 427;  // 2 pixels each
  PlotWindows drawn = PlotWindowsOf(response);
  const auto& windows = drawn.windows;
  RecognitionAnswer answer;
  if (windows.empty()) return answer;
  answer.window_seconds = windows.front()->end_seconds() - windows.front()->start_seconds();
  answer.labels = LabelsOf(windows, unknown_threshold);
  const std::map<std::string, int> label_indices = LabelIndices(answer.labels);
  const std::map<std::string, int> clip_indices = ClipIndices(windows, label_indices, answer.clips);
  for (const v1::RecognitionWindow* window : windows) {
    if (window->has_unknown_probability()) answer.has_unknown = true;
    if (IsUnknown(*window, unknown_threshold)) ++answer.unknown_windows;
  }
  answer.windows_per_column = (windows.size() + kMaxColumns - 1) / kMaxColumns;
  std::vector<AnswerColumn> group;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    group.push_back(
        ColumnOf(*windows[i], drawn.cells[i], unknown_threshold, label_indices, clip_indices));
    if (group.size() < answer.windows_per_column && i + 1 < windows.size()) continue;
    answer.columns.push_back(MeanOf(group));
    group.clear();
  }
  answer.windows = std::move(drawn.cells);
  return answer;
}

}  // namespace motiondb::client
