#include "client/cli/query/estimation_text.h"

#include <fmt/format.h>
#include <motiondb/client.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>

#include "client/cli/terminal/print.h"

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

}  // namespace motiondb::client
