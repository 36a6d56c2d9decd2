#include "client/cli/answer_text.h"

#include <fmt/format.h>
#include <motiondb/client.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "client/cli/database_text.h"
#include "client/cli/print.h"
#include "client/cli/resource_name.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

// Number of labels shown for each window.
constexpr int kShownLabels = 3;
// Less probable labels are not shown, except the first.
constexpr double kMinShownProbability = 0.005;

std::string Label(const v1::RecognitionWindow& window, int rank) {
  if (rank >= window.labels_size()) return "";
  const auto& label = window.labels(rank);
  if (rank > 0 && label.probability() < kMinShownProbability) return "";
  return fmt::format("{} {:.2f}", LabelOrPlaceholder(label.label()), label.probability());
}

// What the window is called, then less probable labels. With `with_unknown` the list has one more
// cell for the probability of unknown motion.
std::vector<std::string> LabelCells(const v1::RecognitionWindow& window, double unknown_threshold,
                                    bool with_unknown) {
  std::vector<std::string> cells;
  cells.reserve(kShownLabels + 1);
  for (int i = 0; i < kShownLabels; ++i) cells.push_back(Label(window, i));
  if (with_unknown) {
    cells.insert(IsUnknown(window, unknown_threshold) ? cells.begin() : cells.end(),
                 window.has_unknown_probability() ? UnknownText(window.unknown_probability()) : "");
  }
  return cells;
}

// "walk 93 % (14 of 15 windows), unknown 7 % (1 of 15 windows)"
std::string Summary(const v1::RecognizeResponse& response, double unknown_threshold) {
  std::map<std::string, int> windows_of;
  int unknown = 0;
  for (const auto& window : response.windows()) {
    if (IsUnknown(window, unknown_threshold)) {
      ++unknown;
    } else if (window.labels_size() > 0) {
      ++windows_of[LabelOrPlaceholder(window.labels(0).label())];
    }
  }
  std::vector<std::pair<std::string, int>> ranked;
  if (unknown > 0) ranked.emplace_back("unknown", unknown);  // apart from a label of that name
  ranked.insert(ranked.end(), windows_of.begin(), windows_of.end());
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

std::string UnknownText(double probability) { return fmt::format("unknown {:.2f}", probability); }

std::string RecognitionText(const v1::RecognizeResponse& response, double unknown_threshold) {
  const bool with_unknown =
      std::any_of(response.windows().begin(), response.windows().end(),
                  [](const auto& window) { return window.has_unknown_probability(); });
  std::vector<Table::Column> columns = {{"", Align::kRight}};
  for (int i = 0; i < kShownLabels + (with_unknown ? 1 : 0); ++i) columns.push_back({""});
  columns.insert(columns.end(), {{""}, {""}});
  Table table(columns);
  for (const auto& window : response.windows()) {
    std::vector<std::string> cells = {
        fmt::format("{:.2f}-{:.2f} s", window.start_seconds(), window.end_seconds())};
    for (std::string& cell : LabelCells(window, unknown_threshold, with_unknown)) {
      cells.push_back(std::move(cell));
    }
    cells.push_back(fmt::format("familiarity {:.2f}", window.familiarity()));
    cells.push_back(window.clips_size() == 0 ? "no clip explains it"
                                             : "best clip " + ShortName(window.clips(0).clip()));
    table.AddRow(cells);
  }
  return table.ToString() + Summary(response, unknown_threshold) + "\n" +
         CalibrationNote(response.calibration());
}

namespace {

constexpr size_t kLineColumns = 96;

// Returns "  12x5 13x3 ...", wrapped into lines.
std::string RunsText(const v1::NodePath& path) {
  std::string text;
  std::string line = " ";
  for (int begin = 0, end = 0; begin < path.node_ids_size(); begin = end) {
    while (end < path.node_ids_size() && path.node_ids(end) == path.node_ids(begin)) ++end;
    const std::string run = fmt::format(" {}x{}", path.node_ids(begin), end - begin);
    if (line.size() + run.size() > kLineColumns) {
      text += line + "\n";
      line = " ";
    }
    line += run;
  }
  return text + line + "\n";
}

// Returns "filled in at 1.20 s", then a line for each missing marker.
std::string FilledText(const v1::FilledFrame& frame, const std::vector<std::string>& marker_names) {
  Table table({{"  MISSING"}, {"x, y, z (m)"}, {"EXPECTED ERROR (m)", Align::kRight}});
  const std::vector<float> positions = UnpackFloats(frame.marker_positions());
  const std::vector<float> deviations = UnpackFloats(frame.marker_deviations());
  const size_t markers = std::min({deviations.size(), positions.size() / 3, marker_names.size()});
  for (size_t m = 0; m < markers; ++m) {
    if (deviations[m] == 0) continue;
    table.AddRow({"  " + marker_names[m],
                  fmt::format("{:7.3f} {:7.3f} {:7.3f}", positions[3 * m], positions[3 * m + 1],
                              positions[3 * m + 2]),
                  fmt::format("{:.3f}", deviations[m])});
  }
  return fmt::format("filled in at {:.2f} s\n", frame.seconds()) + table.ToString();
}

}  // namespace

std::string EstimationText(const v1::EstimateResponse& response,
                           const std::vector<std::string>& marker_names) {
  std::string text =
      fmt::format("state: node {} of layer {}, probability {:.3f}\n", response.state().node_id(),
                  response.layer(), response.state().probability());
  int rank = 0;
  for (const auto& path : response.paths()) {
    const double seconds =
        response.frame_rate_hz() > 0 ? path.node_ids_size() / response.frame_rate_hz() : 0;
    text +=
        fmt::format("path {}: {}, {:.2f} s at {:g} Hz, log probability {:.2f}, as node x frames\n",
                    ++rank, CountText(path.node_ids_size(), "frame"), seconds,
                    response.frame_rate_hz(), path.log_probability());
    text += RunsText(path);
  }
  if (rank == 0) text += "no path explains the observation\n";
  for (const auto& frame : response.filled_frames()) text += FilledText(frame, marker_names);
  return text;
}

namespace {

constexpr int kShownNodes = 5;
constexpr int kShownClips = 4;

std::string ClipsOf(const v1::NextNode& node) {
  std::string text;
  for (int i = 0; i < std::min(node.clips_size(), kShownClips); ++i) {
    text += (i > 0 ? " " : "") + text::DisplayText(ShortName(node.clips(i)));
  }
  if (node.clips_size() > kShownClips) {
    text += fmt::format(" and {} more", node.clips_size() - kShownClips);
  }
  return text;
}

std::string NextNodesText(const v1::PredictResponse& response) {
  if (response.next_nodes_size() == 0) return "  no next node is known\n";
  Table table({{""}, {"", Align::kRight}, {""}});
  for (int i = 0; i < std::min(response.next_nodes_size(), kShownNodes); ++i) {
    const auto& next = response.next_nodes(i);
    table.AddRow({fmt::format("  next node {}", next.node_id()),
                  fmt::format("{:.2f}", next.probability()),
                  next.clips_size() == 0 ? "" : "as in " + ClipsOf(next)});
  }
  return table.ToString();
}

std::string Position(double x, double y, double z) {
  return fmt::format("{:7.3f} {:7.3f} {:7.3f}", x, y, z);
}

// Returns the mean of all markers, the position of the body.
std::string MiddleOf(const std::vector<float>& positions) {
  const size_t markers = positions.size() / 3;
  double sum[3] = {0, 0, 0};
  for (size_t i = 0; i < 3 * markers; ++i) sum[i % 3] += positions[i];
  return Position(sum[0] / markers, sum[1] / markers, sum[2] / markers);
}

std::string HorizonsText(const v1::PredictResponse& response,
                         const std::vector<std::string>& marker_names) {
  if (response.horizons_size() == 0) return "";
  const std::string first = marker_names.empty() ? "first marker" : marker_names.front();
  Table table({{"  AHEAD", Align::kRight},
               {"WITHIN 5 cm", Align::kRight},
               {"ERROR (m)", Align::kRight},
               {"MIDDLE x, y, z (m)"},
               {first + " x, y, z (m)"}});
  for (const auto& frame : response.horizons()) {
    std::vector<std::string> cells = {
        fmt::format("  {:.2f} s", frame.seconds()),
        frame.has_confidence() ? fmt::format("{:.2f}", frame.confidence()) : "-",
        frame.has_expected_error_m() ? fmt::format("{:.3f}", frame.expected_error_m()) : "-"};
    const std::vector<float> positions = UnpackFloats(frame.marker_positions());
    if (positions.size() >= 3) {
      cells.push_back(MiddleOf(positions));
      cells.push_back(Position(positions[0], positions[1], positions[2]));
    }
    table.AddRow(cells);
  }
  return table.ToString();
}

std::string ExtrapolationNotes(const v1::PredictResponse& response, double unknown_threshold) {
  std::string notes;
  if (IsUnknown(response, unknown_threshold)) {
    notes += UnknownText(response.unknown_probability()) +
             ": the motion before that time is unlike the stored motion; the prediction "
             "extrapolates\n";
  }
  const auto& horizons = response.horizons();
  const auto first = std::ranges::find_if(
      horizons, [](const v1::PredictedFrame& frame) { return frame.extrapolated(); });
  if (first != horizons.end()) {
    notes += fmt::format(
        "extrapolated from {:.2f} s: no similar stored motion continues that long, or the error "
        "that far ahead was never measured\n",
        first->seconds());
  }
  return notes;
}

}  // namespace

std::string PredictionText(const v1::PredictResponse& response,
                           const std::vector<std::string>& marker_names, double unknown_threshold) {
  return fmt::format("from {:.2f} s, in node {} of layer {} (probability {:.2f})\n",
                     response.at_seconds(), response.state().node_id(), response.layer(),
                     response.state().probability()) +
         NextNodesText(response) + HorizonsText(response, marker_names) +
         ExtrapolationNotes(response, unknown_threshold) + CalibrationNote(response.calibration());
}

}  // namespace motiondb::client
