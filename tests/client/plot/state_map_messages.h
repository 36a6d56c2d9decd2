// The messages of a small map, as a server sends them.
#pragma once

#include <motiondb/v1/view.pb.h>

#include <string>
#include <vector>

#include "tests/support/packed_floats.h"

namespace motiondb::tests {

inline v1::ReadStateMapResponse MapHeader(const std::string& first_label = "walk") {
  v1::ReadStateMapResponse part;
  v1::StateMapHeader& header = *part.mutable_header();
  header.set_layer(3);
  for (const int count : {1, 2, 4}) header.add_nodes_per_layer(count);
  for (const double fraction : {0.5, 0.25, 0.125}) header.add_variance_fractions(fraction);
  header.add_clips("databases/walks/clips/07_01");
  header.add_clips("databases/walks/clips/09_03");
  header.add_labels(first_label);
  header.add_labels("jog");
  return part;
}

// Four nodes, 4 to 7, at (-2, 0, 0), (2, 0, 1), (0, -1, 0) and (0, 1, 0) with semi-axes 0.4, 0.2
// and 0.1 along the axes.
inline v1::ReadStateMapResponse MapNodes() {
  v1::ReadStateMapResponse part;
  v1::StateMapNodes& nodes = *part.mutable_nodes();
  std::vector<float> means, semi_axes;
  const float positions[4][3] = {{-2, 0, 0}, {2, 0, 1}, {0, -1, 0}, {0, 1, 0}};
  for (int i = 0; i < 4; ++i) {
    nodes.add_node_ids(4 + i);
    nodes.add_parent_ids(2 + i / 2);
    nodes.add_frame_counts(10 * (i + 1));
    nodes.add_main_clips(i / 2);
    nodes.add_label_fractions(0.75F);
    means.insert(means.end(), positions[i], positions[i] + 3);
    const std::vector<float> axes = {0.4F, 0, 0, 0, 0.2F, 0, 0, 0, 0.1F};
    semi_axes.insert(semi_axes.end(), axes.begin(), axes.end());
  }
  nodes.set_means(Pack(means));
  nodes.set_semi_axes(Pack(semi_axes));
  return part;
}

// 4 -> 6 -> 5 -> 7 -> 4, and 4 -> 4.
inline v1::ReadStateMapResponse MapTransitions() {
  v1::ReadStateMapResponse part;
  v1::StateMapTransitions& transitions = *part.mutable_transitions();
  const auto add = [&](int from, int to, float probability) {
    transitions.add_from_node_ids(from);
    transitions.add_to_node_ids(to);
    transitions.add_probabilities(probability);
  };
  add(4, 4, 0.75F);
  add(4, 6, 0.25F);
  add(5, 7, 1);
  add(6, 5, 0.5F);
  add(7, 4, 0.01F);
  return part;
}

inline v1::ReadStateMapResponse MapPoints() {
  v1::ReadStateMapResponse part;
  v1::StateMapPoints& points = *part.mutable_points();
  points.set_positions(Pack({-2, 0.5F, 0, 1, 0, 0.5F, 0, -1.1F, 0}));
  for (int i = 0; i < 3; ++i) {
    points.add_clips(i / 2);
    points.add_frames(i);
    points.add_node_ids(4 + i);
  }
  return part;
}

// A figure of two markers with a bone.
inline v1::Figure TwoMarkers() {
  v1::Figure figure;
  figure.add_marker_names("head");
  figure.add_marker_names("foot");
  v1::Bone& bone = *figure.add_marker_bones();
  bone.set_from_point(0);
  bone.set_to_point(1);
  return figure;
}

inline std::vector<float> TwoMarkerPose(float x) { return {x, 0, 1.7F, x, 0.1F, 0}; }

}  // namespace motiondb::tests
