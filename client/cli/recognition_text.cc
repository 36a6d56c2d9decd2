#include "client/cli/recognition_text.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "client/cli/count_text.h"
#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/table.h"

namespace motiondb::client {
namespace {

// Labels shown of each window.
constexpr int kShownLabels = 3;
// A label less probable than this, after the first, says nothing.
constexpr double kShownProbability = 0.005;

std::string Label(const v1::RecognitionWindow& window, int rank) {
  if (rank >= window.labels_size()) return "";
  const auto& label = window.labels(rank);
  if (rank > 0 && label.probability() < kShownProbability) return "";
  return fmt::format("{} {:.2f}", LabelWord(label.label()), label.probability());
}

// "walk 93 % (14 of 15 windows), jog 7 % (1 of 15 windows)"
std::string Summary(const v1::RecognizeResponse& response) {
  std::map<std::string, int> windows_of;
  for (const auto& window : response.windows()) {
    if (window.labels_size() > 0) ++windows_of[LabelWord(window.labels(0).label())];
  }
  std::vector<std::pair<std::string, int>> ranked(windows_of.begin(), windows_of.end());
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  const int total = response.windows_size();
  std::string text;
  for (const auto& [label, count] : ranked) {
    text += fmt::format("{}{} {:.0f} % ({} of {})", text.empty() ? "" : ", ", label,
                        100.0 * count / total, count, CountText(total, "window"));
  }
  return text.empty() ? "nothing recognized" : text;
}

}  // namespace

std::string RecognitionText(const v1::RecognizeResponse& response) {
  std::vector<Table::Column> columns = {{"", Align::kRight}};
  for (int i = 0; i < kShownLabels; ++i) columns.push_back({""});
  columns.insert(columns.end(), {{""}, {""}});
  Table table(columns);
  for (const auto& window : response.windows()) {
    std::vector<std::string> cells = {
        fmt::format("{:.2f}-{:.2f} s", window.start_seconds(), window.end_seconds())};
    for (int i = 0; i < kShownLabels; ++i) cells.push_back(Label(window, i));
    cells.push_back(fmt::format("familiarity {:.2f}", window.familiarity()));
    cells.push_back(window.clips_size() == 0 ? "no clip explains it"
                                             : "best clip " + ShortName(window.clips(0).clip()));
    table.AddRow(cells);
  }
  return table.ToString() + Summary(response) + "\n";
}

}  // namespace motiondb::client
