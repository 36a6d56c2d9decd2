#include "tests/support/project_paths.h"

namespace motiondb::tests {

std::string SourcePath(const std::string& relative) { return MOTIONDB_SOURCE_DIR "/" + relative; }

std::string MotiondbProgram() { return MOTIONDB_BINARY_DIR "/client/cli/motiondb"; }

std::string MotiondbdProgram() { return MOTIONDB_BINARY_DIR "/server/motiondbd"; }

}  // namespace motiondb::tests
