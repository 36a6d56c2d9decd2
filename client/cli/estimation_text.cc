#include "client/cli/estimation_text.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>

#include "client/cli/count_text.h"
#include "client/cli/table.h"

namespace motiondb::client {
namespace {

constexpr size_t kLineColumns = 96;

// "  12x5 13x3 ...", broken into lines.
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

// "missing at 1.20 s:", then a line for each missing marker.
std::string FilledText(const v1::FilledFrame& frame, const std::vector<std::string>& marker_names) {
  Table table({{"  MISSING"}, {"x, y, z (m)"}, {"EXPECTED ERROR (m)", Align::kRight}});
  const int markers = std::min({frame.marker_deviations_size(), frame.marker_positions_size() / 3,
                                static_cast<int>(marker_names.size())});
  for (int m = 0; m < markers; ++m) {
    if (frame.marker_deviations(m) == 0) continue;
    table.AddRow({"  " + marker_names[m],
                  fmt::format("{:7.3f} {:7.3f} {:7.3f}", frame.marker_positions(3 * m),
                              frame.marker_positions(3 * m + 1), frame.marker_positions(3 * m + 2)),
                  fmt::format("{:.3f}", frame.marker_deviations(m))});
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

}  // namespace motiondb::client
