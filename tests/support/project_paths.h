// Files of the project, and the programs of this build.
#pragma once

#include <string>

namespace motiondb::tests {

// Returns the path of a file or folder of the project.
std::string SourcePath(const std::string& relative);

// Paths of the programs. A test that uses them depends on their targets.
std::string MotiondbProgram();
std::string MotiondbdProgram();

}  // namespace motiondb::tests
