#include "client/cli/picture/state_map.h"

#include <fmt/format.h>
#include <motiondb/client.h>
#include <motiondb/v1/view.pb.h>

#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

absl::Status WrongMap(const std::string& what) {
  return absl::DataLossError(
      fmt::format("the server sent a map whose {} do not fit together", what));
}

AxisVector VectorAt(const std::vector<float>& values, std::size_t first) {
  return {values[first], values[first + 1], values[first + 2]};
}

}  // namespace

absl::Status StateMap::Add(const v1::ReadStateMapResponse& part) {
  if (part.has_header()) return AddHeader(part.header());
  if (part.has_nodes()) return AddNodes(part.nodes());
  if (part.has_transitions()) return AddTransitions(part.transitions());
  return part.has_points() ? AddPoints(part.points()) : absl::OkStatus();
}

absl::Status StateMap::AddHeader(const v1::StateMapHeader& header) {
  if (!clips_.empty()) return WrongMap("two headers");
  if (header.clips_size() != header.labels_size()) return WrongMap("clips and labels");
  layer_ = header.layer();
  layer_count_ = header.nodes_per_layer_size();
  variance_fractions_.assign(header.variance_fractions().begin(),
                             header.variance_fractions().end());
  for (const std::string& clip : header.clips()) clips_.push_back(ShortName(clip));
  for (const std::string& label : header.labels()) labels_.push_back(LabelOrPlaceholder(label));
  return absl::OkStatus();
}

absl::Status StateMap::AddNodes(const v1::StateMapNodes& nodes) {
  const int count = nodes.node_ids_size();
  const std::vector<float> means = UnpackFloats(nodes.means());
  const std::vector<float> semi_axes = UnpackFloats(nodes.semi_axes());
  const auto size = static_cast<std::size_t>(count);
  if (nodes.frame_counts_size() != count || nodes.main_clips_size() != count ||
      nodes.label_fractions_size() != count || means.size() != 3 * size ||
      semi_axes.size() != 9 * size) {
    return WrongMap("nodes");
  }
  for (int i = 0; i < count; ++i) {
    if (!IsClip(nodes.main_clips(i))) return WrongMap("nodes and clips");
    const auto at = static_cast<std::size_t>(i);
    MapNode& node = nodes_.emplace_back();
    node.id = nodes.node_ids(i);
    node.frame_count = nodes.frame_counts(i);
    node.main_clip = nodes.main_clips(i);
    node.label_fraction = nodes.label_fractions(i);
    node.mean = VectorAt(means, 3 * at);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.semi_axes[axis] = VectorAt(semi_axes, 9 * at + 3 * axis);
    }
    index_of_node_[node.id] = static_cast<int>(nodes_.size()) - 1;
  }
  return absl::OkStatus();
}

absl::Status StateMap::AddTransitions(const v1::StateMapTransitions& transitions) {
  const int count = transitions.from_node_ids_size();
  if (transitions.to_node_ids_size() != count || transitions.probabilities_size() != count) {
    return WrongMap("transitions");
  }
  for (int i = 0; i < count; ++i) {
    const int from = IndexOf(transitions.from_node_ids(i));
    const int to = IndexOf(transitions.to_node_ids(i));
    if (from < 0 || to < 0) return WrongMap("transitions and nodes");
    if (from != to) transitions_.push_back({from, to, transitions.probabilities(i)});
  }
  return absl::OkStatus();
}

absl::Status StateMap::AddPoints(const v1::StateMapPoints& points) {
  const std::vector<float> positions = UnpackFloats(points.positions());
  const int count = points.clips_size();
  if (positions.size() != 3 * static_cast<std::size_t>(count)) return WrongMap("points");
  for (int i = 0; i < count; ++i) {
    if (!IsClip(points.clips(i))) return WrongMap("points and clips");
    points_.push_back({points.clips(i), VectorAt(positions, 3 * static_cast<std::size_t>(i))});
  }
  return absl::OkStatus();
}

int StateMap::IndexOf(int node_id) const {
  const auto found = index_of_node_.find(node_id);
  return found == index_of_node_.end() ? -1 : found->second;
}

}  // namespace motiondb::client
