// The layer of a model in principal axes, as ReadStateMap sends it.
#pragma once

#include <motiondb/messages.h>

#include <array>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace motiondb::v1 {
class StateMapHeader;
class StateMapNodes;
class StateMapTransitions;
class StateMapPoints;
}  // namespace motiondb::v1

namespace motiondb::client {

using AxisVector = std::array<double, 3>;  // in the first three principal axes, scaled units

struct MapNode {
  int id = 0;
  int frame_count = 0;
  int main_clip = 0;          // index of a clip
  double label_fraction = 0;  // 0 to 1
  AxisVector mean = {};
  std::array<AxisVector, 3> semi_axes = {};
};

// A transition to another node. Indices of nodes.
struct MapTransition {
  int from = 0;
  int to = 0;
  double probability = 0;
};

struct MapPoint {
  int clip = 0;  // index of a clip
  AxisVector position = {};
};

class StateMap {
 public:
  // Adds a message of the stream, in order. DATA_LOSS: its fields do not fit together.
  absl::Status Add(const v1::ReadStateMapResponse& part);

  int layer() const { return layer_; }
  int layer_count() const { return layer_count_; }
  // Fraction of the variance along each axis; fewer than three if the model has fewer.
  const std::vector<double>& variance_fractions() const { return variance_fractions_; }
  const std::vector<std::string>& clips() const { return clips_; }
  const std::vector<std::string>& labels() const { return labels_; }  // one for each clip
  const std::vector<MapNode>& nodes() const { return nodes_; }
  // The probability that a node is not left is not among them.
  const std::vector<MapTransition>& transitions() const { return transitions_; }
  const std::vector<MapPoint>& points() const { return points_; }

  // Returns the index of a node, or -1.
  int IndexOf(int node_id) const;

 private:
  absl::Status AddHeader(const v1::StateMapHeader& header);
  absl::Status AddNodes(const v1::StateMapNodes& nodes);
  absl::Status AddTransitions(const v1::StateMapTransitions& transitions);
  absl::Status AddPoints(const v1::StateMapPoints& points);
  bool IsClip(int index) const { return index >= 0 && index < static_cast<int>(clips_.size()); }

  int layer_ = 0;
  int layer_count_ = 0;
  std::vector<double> variance_fractions_;
  std::vector<std::string> clips_;
  std::vector<std::string> labels_;
  std::vector<MapNode> nodes_;
  std::vector<MapTransition> transitions_;
  std::vector<MapPoint> points_;
  std::map<int, int> index_of_node_;
};

}  // namespace motiondb::client
