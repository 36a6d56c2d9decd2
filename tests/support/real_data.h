// Location of the recorded motion: MOTIONDB_DATA, or ../shared/data beside the project. Tests that
// need it begin with MOTIONDB_REQUIRE_DATA, which skips them with one line if it is missing.
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
    WARN("skipped: no recorded motion in " << motiondb::tests::DataDir().string()); \
    return;                                                                         \
  }                                                                                 \
  static_assert(true)
