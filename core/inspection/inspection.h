// What a motion file contains and how a database would store it, for `motiondb inspect`.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/format/motion_file.h"
#include "core/mapping/figure.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// A joint or marker of the file.
struct InspectedPoint {
  std::string name;
  int parent = -1;                     // -1: a root joint or a marker
  std::string role;                    // point of the body, such as "left knee"; empty: none
  double confidence = 0;               // of the role, 0 to 1
  double missing = 0;                  // fraction of frames without the marker
  std::array<double, 3> position_m{};  // in the middle frame, world; NaN: missing
};

struct Inspection {
  SourceReport report;
  bool has_hierarchy = false;
  double frame_rate_hz = 0;
  int frame_count = 0;
  std::vector<InspectedPoint> points;
  std::string take;             // the inspected one, of a file with several
  std::vector<TakeInfo> takes;  // all of them

  std::string mapping;  // how the points are mapped to standard34; empty: not at all
  std::string
      mapping_file;  // that mapping, or a draft of one, as a file for `motiondb mapping add`
  // The rest needs a mapping.
  std::optional<double> leg_length_m;
  std::optional<double> stature_m;
  std::optional<double> foot_slide_m_per_s;  // median speed of a foot on the floor
  std::vector<std::string> notes;  // reference pose, glitches, filled gaps, derived markers
  std::vector<std::string> suggested_options;  // of the command line, against the problems
  std::vector<std::string> problems;           // why ingest would reject the file
};

// Converts a motion to the standard marker set, as ingest with the policy `repair` does. Problems
// are in the result. `file_name` names the mapping.
Inspection InspectMotion(std::string_view file_name, const MotionFile& file,
                         std::optional<double> leg_length_m);

// The parts of InspectMotion.

// Returns the stature (m): median length of the segments from ankle to top of the head, and the
// height of the ankle. Nothing if a marker is missing in all frames. REQUIRES: `motion` has the
// markers of standard34.
std::optional<double> Stature(const MarkerMotion& motion, double leg_length_m);

// Returns the median horizontal speed (m/s) of the heels and toes while they are near the floor,
// which is where they are lowest. Nothing if no foot is near the floor for long enough. 0.1 and
// more is visible sliding. REQUIRES: as above.
std::optional<double> FootSlide(const MarkerMotion& motion, double leg_length_m);

// Returns a mapping with this name in the marker-set file's format to complete by hand: rules for
// the markers whose roles were found, with their confidences, and comments for the others. Markers
// with a default rule are left out.
std::string DraftMapping(const MarkerSet& set, const PointCloud& points, const std::string& name);

}  // namespace motiondb::core
