// The mappings of the default marker set for robots, which are read from URDF files. Safe to call
// from any thread.
#pragma once

#include <string_view>

namespace motiondb::core {

// Text in the marker-set file's format, to follow the set itself. Signatures are URDF joint names.
std::string_view Standard34RobotMappings();

}  // namespace motiondb::core
