// Marker-set files: a virtual marker set and its mappings, as text. Format: docs/file_formats.md.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

// INVALID_ARGUMENT names file, line and the expected content.
absl::StatusOr<MarkerScheme> ReadMarkerSetFile(SourceFile file);

// Reads a file with mappings only, with or without a line `extend NAME`, for an existing set.
// INVALID_ARGUMENT names file, line and the expected content.
absl::StatusOr<std::vector<MarkerMapping>> ReadMappings(SourceFile file, const MarkerScheme& base);

// Returns the scheme as text. ReadMarkerSetFile reads back the same scheme.
std::string WriteMarkerSetFile(const MarkerScheme& scheme);

// Returns one mapping of the set as lines of a marker-set file.
std::string WriteMapping(const MarkerSet& set, const MarkerMapping& mapping);

// The default set: 34 markers, with mappings for the CMU and HDM05 ASF skeletons, common BVH
// conversions of them, and robots. Optical markers are mapped by core/mapping.
const MarkerScheme& StandardScheme();

// Returns mappings for robots in the marker-set file's format, to append to the default set.
// Signatures are URDF joint names.
std::string_view Standard34RobotMappings();

}  // namespace motiondb::core
