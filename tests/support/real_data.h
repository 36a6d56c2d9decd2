// Where the real motion is: ../shared/data beside the project, or MOTIONDB_DATA. Tests that need it
// begin with MOTIONDB_REQUIRE_DATA, which says so in one line and passes where it is absent.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace motiondb::tests {

std::filesystem::path DataDir();

inline std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

}  // namespace motiondb::tests

#define MOTIONDB_REQUIRE_DATA()                                                     \
  if (!std::filesystem::exists(motiondb::tests::DataDir() / "index.tsv")) {         \
    WARN("skipped: real motion is not at " << motiondb::tests::DataDir().string()); \
    return;                                                                         \
  }                                                                                 \
  static_assert(true)
