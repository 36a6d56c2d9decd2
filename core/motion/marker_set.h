// Virtual marker sets (section III-A): named points on the body, the uniform representation of
// every motion; and mappings from one kind of skeleton or real marker set to these points.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// Indices into MarkerSet::markers of the points that define the reference frame and the subject's
// size.
struct Landmarks {
  int left_hip = -1;
  int right_hip = -1;
  // Hip, knee and ankle of each leg of which the set has all three: none, one or two legs.
  std::vector<std::array<int, 3>> legs;
};

struct MarkerSet {
  std::string name;
  std::vector<std::string> markers;  // N_v unique names, in the order of the state vector
  Landmarks landmarks;

  int marker_count() const { return static_cast<int>(markers.size()); }
  // Length of a state vector: position and velocity of every marker.
  int dimension_count() const { return 6 * marker_count(); }
  // Index of a name in `markers`, or -1. O(markers).
  int FindMarker(std::string_view marker) const;
};

// A joint or source marker from which a virtual marker is computed.
struct WeightedPoint {
  std::string name;
  double weight = 1;
};

// Position of one virtual marker: a weighted sum of points (weights sum to 1) plus an offset in the
// frame of a link. The offset is in leg lengths, so that it fits every subject.
struct MarkerRule {
  std::vector<WeightedPoint> points;  // none: the marker is missing
  std::string offset_joint;           // empty: no offset
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
};

struct MarkerMapping {
  std::string name;
  // The mapping fits a motion that has all these joints or markers.
  std::vector<std::string> signature;
  std::vector<MarkerRule> rules;  // one for each marker of the set
};

// A marker set with its mappings: the content of a marker-set file.
struct MarkerScheme {
  MarkerSet set;
  // Rules in terms of the set's own markers, for markers without a rule in a mapping. Empty, or one
  // for each marker; one without points is no rule.
  std::vector<MarkerRule> default_rules;
  std::vector<MarkerMapping> mappings;
};

// Returns the scheme whose markers are the motion's own joints (without end sites) or markers, for
// the setting `source`. INVALID_ARGUMENT if RecognizeLandmarks does not find both hips.
absl::StatusOr<MarkerScheme> SourceScheme(const Motion& motion);

// Returns the name of a joint or marker for comparison: lower-case letters and digits, without a
// "subject:" prefix.
std::string PlainName(std::string_view name);

// Returns the landmarks found by marker or joint names ("LeftUpLeg", "lfemur", "LASI", ...).
Landmarks RecognizeLandmarks(const std::vector<std::string>& names);

// Converts a motion to the set's markers at the motion's own frame rate. Uses the mapping with the
// largest signature among those that fit. Markers with the set's own names need no mapping.
// INVALID_ARGUMENT if no mapping fits; the message names what the closest mapping lacks. CANCELLED.
// `leg_length_m` replaces the estimated size that scales offsets. Missing source markers yield NaN.
absl::StatusOr<MarkerMotion> ApplyScheme(const MarkerScheme& scheme, const Motion& motion,
                                         std::optional<double> leg_length_m = std::nullopt,
                                         const Cancelled& cancelled = {});

inline constexpr std::size_t kMaxMarkers = 256;  // seven times the standard set; faces have fewer
inline constexpr std::size_t kMaxMappings = 200;
inline constexpr std::size_t kMaxRulePoints = 32;  // points of one virtual marker

// A MarkerRule with indices instead of names.
struct BoundRule {
  std::vector<std::pair<int, double>> points;  // joint or source marker, and its weight
  int offset_joint = -1;                       // -1: no offset
  Eigen::Vector3d offset;                      // in that joint's frame, in leg lengths
};

// A mapping bound to one skeleton or marker list.
struct BoundMapping {
  std::string name;
  std::vector<BoundRule> rules;  // one for each marker of the set
  bool has_offsets = false;
};

// Returns the mapping with the largest signature among those that fit `names`, bound to them; the
// mapping "own names", which is not in the scheme, if the points have the names of the markers.
// INVALID_ARGUMENT if none fits (the message names what the closest mapping lacks) or if a rule
// uses an unknown name.
absl::StatusOr<BoundMapping> BindMapping(const MarkerScheme& scheme,
                                         const std::vector<std::string>& names);

std::vector<std::string> JointNames(const Skeleton& skeleton);

}  // namespace motiondb::core
