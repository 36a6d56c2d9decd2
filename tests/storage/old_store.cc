#include "tests/storage/old_store.h"

#include <zlib.h>

#include <catch2/catch.hpp>

#include "tests/support/project_paths.h"

namespace motiondb::tests {

std::string OldStore(int version) {
  const std::string path =
      SourcePath("tests/storage/old_stores/version" + std::to_string(version) + ".db.gz");
  const gzFile file = gzopen(path.c_str(), "rb");
  INFO(path);
  REQUIRE(file != nullptr);
  std::string bytes;
  char block[65536];
  int count = 0;
  while ((count = gzread(file, block, sizeof(block))) > 0) {
    bytes.append(block, static_cast<std::size_t>(count));
  }
  gzclose(file);
  REQUIRE(count == 0);
  return bytes;
}

}  // namespace motiondb::tests
