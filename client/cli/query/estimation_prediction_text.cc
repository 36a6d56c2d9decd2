#include "client/cli/query/estimation_prediction_text.h"

#include <fmt/format.h>
#include <motiondb/client.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "client/cli/database_text.h"
#include "client/cli/query/recognition_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

constexpr std::size_t kMaxLineColumns = 96;

struct NodeRun {
  int node = 0;
  int first_frame = 0;
  int frames = 0;
};

std::vector<NodeRun> NodeRunsOf(const v1::NodePath& path) {
  std::vector<NodeRun> runs;
  for (int i = 0; i < path.node_ids_size(); ++i) {
    if (runs.empty() || runs.back().node != path.node_ids(i)) {
      runs.push_back({path.node_ids(i), i, 0});
    }
    ++runs.back().frames;
  }
  return runs;
}

// Returns "  12x5 13x3 ...", wrapped into lines.
std::string NodeRunsText(const v1::NodePath& path) {
  std::string words;
  for (const NodeRun& run : NodeRunsOf(path)) words += fmt::format(" {}x{}", run.node, run.frames);
  return "  " + Wrapped(words, std::min(OutputSize().columns, kMaxLineColumns), 2) + "\n";
}

// Returns "filled in at 1.20 s", then a line for each missing marker.
std::string FilledText(const v1::FilledFrame& frame, const std::vector<std::string>& marker_names) {
  Table table({{"MISSING"},
               {"X (m)", Align::kRight},
               {"Y (m)", Align::kRight},
               {"Z (m)", Align::kRight},
               {"EXPECTED ERROR (m)", Align::kRight}});
  const std::vector<float> positions = UnpackFloats(frame.marker_positions());
  const std::vector<float> deviations = UnpackFloats(frame.marker_deviations());
  const size_t markers = std::min({deviations.size(), positions.size() / 3, marker_names.size()});
  for (size_t m = 0; m < markers; ++m) {
    if (deviations[m] == 0) continue;
    table.AddRow({marker_names[m], Cell(positions[3 * m], 3), Cell(positions[3 * m + 1], 3),
                  Cell(positions[3 * m + 2], 3), Cell(deviations[m], 3)});
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
    text += NodeRunsText(path);
  }
  if (rank == 0) text += "no path explains the observation\n";
  for (const auto& frame : response.filled_frames()) text += FilledText(frame, marker_names);
  return text;
}

Table EstimationTable(const v1::EstimateResponse& response) {
  Table table({{"PATH", Align::kRight},
               {"LAYER", Align::kRight},
               {"NODE", Align::kRight},
               {"FROM (s)", Align::kRight},
               {"FRAMES", Align::kRight}});
  for (int rank = 0; rank < response.paths_size(); ++rank) {
    for (const NodeRun& run : NodeRunsOf(response.paths(rank))) {
      const double rate = response.frame_rate_hz();
      table.AddRow({rank + 1, response.layer(), run.node,
                    Cell(rate > 0 ? run.first_frame / rate : 0, 3), run.frames});
    }
  }
  return table;
}

namespace {

constexpr int kShownNodes = 5;
constexpr int kShownClips = 4;
constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

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
  if (response.next_nodes_size() == 0) return "no next node is known\n";
  Table table({{"NEXT NODE", Align::kRight}, {"PROBABILITY", Align::kRight}, {"AS IN"}});
  for (int i = 0; i < std::min(response.next_nodes_size(), kShownNodes); ++i) {
    const auto& next = response.next_nodes(i);
    table.AddRow({next.node_id(), Cell(next.probability(), 2), ClipsOf(next)});
  }
  return table.ToString();
}

// Returns the mean of all markers; NaN without markers.
std::array<double, 3> MiddleOf(const v1::PredictedFrame& frame) {
  const std::vector<float> positions = UnpackFloats(frame.marker_positions());
  const size_t markers = positions.size() / 3;
  std::array<double, 3> middle = {0, 0, 0};
  for (size_t i = 0; i < 3 * markers; ++i) middle[i % 3] += positions[i];
  for (double& coordinate : middle) {
    coordinate = markers > 0 ? coordinate / static_cast<double>(markers) : kNotKnown;
  }
  return middle;
}

// Returns the mean distance (m) of the markers from the motion at the same time, from its nearest
// frame. NaN if the motion is absent or too short.
double ActualError(const PredictionView& view, double at_seconds, const v1::PredictedFrame& frame) {
  const std::vector<float>& seen = view.motion_m;
  const long now = std::lround((at_seconds + frame.seconds()) * view.frame_rate_hz);
  const std::vector<float> predicted = UnpackFloats(frame.marker_positions());
  const std::size_t first = static_cast<std::size_t>(now) * predicted.size();
  if (now < 0 || predicted.empty() || first + predicted.size() > seen.size()) return kNotKnown;
  double sum = 0;
  int markers = 0;
  for (std::size_t m = 0; m + 2 < predicted.size(); m += 3) {
    const double distance =
        std::hypot(predicted[m] - seen[first + m], predicted[m + 1] - seen[first + m + 1],
                   predicted[m + 2] - seen[first + m + 2]);
    if (std::isnan(distance)) continue;  // a missing marker
    sum += distance;
    ++markers;
  }
  return markers > 0 ? sum / markers : kNotKnown;
}

Table HorizonsTable(const v1::PredictResponse& response, const PredictionView& view,
                    bool names_moment) {
  std::vector<Table::Column> columns = {
      {"AHEAD (s)", Align::kRight},  {"WITHIN 5 cm", Align::kRight},  {"ERROR (m)", Align::kRight},
      {"ACTUAL (m)", Align::kRight}, {"MIDDLE X (m)", Align::kRight}, {"Y (m)", Align::kRight},
      {"Z (m)", Align::kRight}};
  if (names_moment) columns.insert(columns.begin(), {"FROM (s)", Align::kRight});
  Table table(columns);
  for (const auto& frame : response.horizons()) {
    const std::array<double, 3> middle = MiddleOf(frame);
    std::vector<Cell> cells = {
        Cell(frame.seconds(), 2),
        Cell(frame.has_confidence() ? frame.confidence() : kNotKnown, 2),
        Cell(frame.has_expected_error_m() ? frame.expected_error_m() : kNotKnown, 3),
        Cell(ActualError(view, response.at_seconds(), frame), 3),
        Cell(middle[0], 3),
        Cell(middle[1], 3),
        Cell(middle[2], 3)};
    if (names_moment) cells.insert(cells.begin(), Cell(response.at_seconds(), 3));
    table.AddRow(std::move(cells));
  }
  return table;
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

std::string PredictionText(const v1::PredictResponse& response, const PredictionView& view) {
  std::string text = fmt::format("from {:.2f} s, in node {} of layer {} (probability {:.2f})\n",
                                 response.at_seconds(), response.state().node_id(),
                                 response.layer(), response.state().probability()) +
                     NextNodesText(response);
  if (response.horizons_size() > 0) text += HorizonsTable(response, view, false).ToString();
  return text + ExtrapolationNotes(response, view.unknown_threshold) +
         CalibrationNote(response.calibration());
}

Table PredictionTable(const v1::PredictResponse& response, const PredictionView& view) {
  return HorizonsTable(response, view, true);
}

}  // namespace motiondb::client
