// A truncated store is served and the missing part is reported, whatever its size.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::truncated_store_test {
namespace {

void Fill(const StoreFile& file) {
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  for (unsigned i = 1; i <= 3; ++i) REQUIRE_OK(store->AddClip(SampleClip("d", "walk", i)));
}

}  // namespace

TEST_CASE("SqliteMotionStore: a truncated file is served, also if a page is incomplete",
          "[storage][truncated]") {
  const int missing = GENERATE(1, 16383, 16384, 16385, 3 * 16384);
  const bool read_only = GENERATE(false, true);
  CAPTURE(missing, read_only);
  const StoreFile file;
  Fill(file);
  const auto size = std::filesystem::file_size(file.path());
  std::filesystem::resize_file(file.path(), size - static_cast<unsigned>(missing));
  const auto store = file.Open({.read_only = read_only});
  REQUIRE(Require(store->ListDatabases({})).size() == 1);
  const std::string text = "was truncated: expected " + std::to_string(size) + " bytes, got " +
                           std::to_string(size - static_cast<unsigned>(missing));
  REQUIRE(store->maintenance().FoundAtOpening().size() == 1);
  REQUIRE_THAT(Findings(*store), Catch::Contains(text));
  if (read_only) {
    REQUIRE(std::filesystem::file_size(file.path()) == size - static_cast<unsigned>(missing));
  } else {
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
  }
}

TEST_CASE("SqliteMotionStore: a file before a checkpoint of its log is not truncated",
          "[storage][truncated]") {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  const StoreFile killed;
  std::filesystem::copy_file(file.path(), killed.path());
  std::filesystem::copy_file(file.path() + "-wal", killed.path() + "-wal");
  REQUIRE(Findings(*killed.Open()).empty());
}

}  // namespace motiondb::tests::truncated_store_test
