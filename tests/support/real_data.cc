#include "tests/support/real_data.h"

#include <cstdlib>

namespace motiondb::tests {

std::filesystem::path DataDir() {
  if (const char* given = std::getenv("MOTIONDB_DATA")) return given;
  return std::filesystem::path(MOTIONDB_SOURCE_DIR).parent_path() / "shared" / "data";
}

}  // namespace motiondb::tests
