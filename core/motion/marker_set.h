// Virtual marker sets (section III-A): named points on the body that every motion is brought to,
// and the mappings that say where those points are on one kind of skeleton or real marker set.
// Plain values; the functions keep no state and are safe to call from any thread.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// Indices into MarkerSet::markers of the points that give the reference frame and the subject's
// size.
struct Landmarks {
  int left_hip = -1;
  int right_hip = -1;
  // Hip, knee and ankle of the legs that are whole in the set: none, one or two.
  std::vector<std::array<int, 3>> legs;
};

struct MarkerSet {
  std::string name;
  std::vector<std::string> markers;  // N_v unique names, in the order of the state vector
  Landmarks landmarks;

  int marker_count() const { return static_cast<int>(markers.size()); }
  // Length of a state vector: position and velocity of every marker.
  int dimension_count() const { return 6 * marker_count(); }
};

// A joint or source marker that a virtual marker is made from.
struct WeightedPoint {
  std::string name;
  double weight = 1;
};

// Where one virtual marker is: a weighted sum of points (weights sum to 1), then an offset in the
// frame of a link, in leg lengths so that it fits every subject.
struct MarkerRule {
  std::vector<WeightedPoint> points;
  std::string offset_joint;  // empty where there is no offset
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
};

struct MarkerMapping {
  std::string name;
  // A motion is of this kind if it has all these joints or markers.
  std::vector<std::string> signature;
  std::vector<MarkerRule> rules;  // one for each marker of the set
};

// A marker set with the mappings known for it: the content of a marker-set file.
struct MarkerScheme {
  MarkerSet set;
  std::vector<MarkerMapping> mappings;
};

// The scheme whose markers are the motion's own joints (end sites left out) or markers, for the
// setting `source`. INVALID_ARGUMENT if left and right hip are not among the names it recognises.
absl::StatusOr<MarkerScheme> SourceScheme(const Motion& motion);

// A joint's or marker's name as customs compare it: lower-case letters and digits, without a
// "subject:" in front.
std::string PlainName(std::string_view name);

// Landmarks that marker or joint names themselves tell ("LeftUpLeg", "lfemur", "LASI", ...).
Landmarks RecognizeLandmarks(const std::vector<std::string>& names);

// Brings a motion to the set's markers at the motion's own frame rate, by the mapping with the most
// signature names of those that fit. Markers that carry the set's own names need no mapping.
// INVALID_ARGUMENT if none fits, naming what the closest one lacks. `leg_length_m` overrides the
// measured size that offsets scale with. Missing source markers make NaN. CANCELLED.
absl::StatusOr<MarkerMotion> ApplyScheme(const MarkerScheme& scheme, const Motion& motion,
                                         std::optional<double> leg_length_m = std::nullopt,
                                         const Cancelled& cancelled = {});

inline constexpr std::size_t kMostMarkers = 256;  // seven times the standard set; faces have fewer
inline constexpr std::size_t kMostMappings = 200;
inline constexpr std::size_t kMostRulePoints = 32;  // that one virtual marker is made from

}  // namespace motiondb::core
