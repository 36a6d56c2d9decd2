#include "tests/support/real_data.h"

#include <cstdlib>

#include "tests/support/project_paths.h"

namespace motiondb::tests {

std::filesystem::path DataDir() {
  if (const char* given = std::getenv("MOTIONDB_DATA")) return given;
  return std::filesystem::path(SourcePath("../shared/data")).lexically_normal();
}

}  // namespace motiondb::tests
