#include "tests/fuzz/seeds/seed_file.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace motiondb::tests {

void WriteSeed(const std::string& target, const std::string& name, std::string_view bytes) {
  const char* const root = std::getenv("MOTIONDB_FUZZ_SEEDS");
  INFO("expected MOTIONDB_FUZZ_SEEDS: the folder for seeds");
  REQUIRE(root != nullptr);
  const std::filesystem::path folder = std::filesystem::path(root) / target;
  std::filesystem::create_directories(folder);
  std::ofstream file(folder / name, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  REQUIRE(file.flush());
}

}  // namespace motiondb::tests
