// Lines between the points of a figure.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/model/distance_spread.h"
#include "core/motion/marker_set.h"
#include "core/motion/skeleton.h"
#include "core/motion/states.h"

namespace motiondb::core {

class Model;

// Two points, as indices; the first is nearer to the root.
using BoneEnds = std::pair<int, int>;

// Returns the minimum spanning tree of the markers, from the left hip outward, by the standard
// deviation of their distances plus kLengthCost of the mean distance: of markers that all move
// together, neighbours are joined. O(markers^2).
inline constexpr double kLengthCost = 0.05;
std::vector<BoneEnds> MarkerBones(const MarkerSet& set, const DistanceSpread& spread);

// The same, from a sample of the model's clips. O(markers^2).
std::vector<BoneEnds> MarkerBones(const Model& model);
// The same, from a sample of one motion that is in no model.
std::vector<BoneEnds> MarkerBones(const MarkerSet& set, const StateSequence& states);

// Returns the bones of a marker set whose markers all are joints of the skeleton: each is joined to
// its nearest ancestor in the set. Empty if a marker is no joint. O(markers * joints).
std::vector<BoneEnds> MarkerBonesOf(const MarkerSet& set, const Skeleton& skeleton);

// Returns the bones of a skeleton: each joint but a root is joined to its parent.
std::vector<BoneEnds> JointBones(const Skeleton& skeleton);

}  // namespace motiondb::core
