#include "client/cli/prediction_text.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>

#include "client/cli/resource_name.h"
#include "client/cli/table.h"
#include "text/display_text.h"

namespace motiondb::client {
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

// The mean of all markers: where the body is.
std::string MiddleOf(const v1::PredictedFrame& frame) {
  const int markers = frame.marker_positions_size() / 3;
  double sum[3] = {0, 0, 0};
  for (int i = 0; i < 3 * markers; ++i) sum[i % 3] += frame.marker_positions(i);
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
        fmt::format("  {:.2f} s", frame.seconds()), fmt::format("{:.2f}", frame.confidence()),
        frame.expected_error_m() > 0 ? fmt::format("{:.3f}", frame.expected_error_m()) : "-"};
    if (frame.marker_positions_size() >= 3) {
      cells.push_back(MiddleOf(frame));
      cells.push_back(Position(frame.marker_positions(0), frame.marker_positions(1),
                               frame.marker_positions(2)));
    }
    table.AddRow(cells);
  }
  return table.ToString();
}

}  // namespace

std::string PredictionText(const v1::PredictResponse& response,
                           const std::vector<std::string>& marker_names) {
  return fmt::format("from {:.2f} s, in node {} of layer {} (probability {:.2f})\n",
                     response.at_seconds(), response.state().node_id(), response.layer(),
                     response.state().probability()) +
         NextNodesText(response) + HorizonsText(response, marker_names);
}

}  // namespace motiondb::client
