// Marker-set files: a virtual marker set and its mappings, as text. The format is described in
// docs/file_formats.md. Safe to call from any thread.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

// INVALID_ARGUMENT names file, line and what was expected.
absl::StatusOr<MarkerScheme> ReadMarkerSetFile(SourceFile file);

// A scheme as text that ReadMarkerSetFile reads back to the same scheme.
std::string WriteMarkerSetFile(const MarkerScheme& scheme);

// The default set: 34 markers, with mappings for the CMU and HDM05 ASF skeletons, common BVH
// conversions of them and the CMU's optical markers.
const MarkerScheme& StandardScheme();

// Text in the marker-set file's format, to follow the set itself. Signatures are URDF joint names.
std::string_view Standard34RobotMappings();

}  // namespace motiondb::core
