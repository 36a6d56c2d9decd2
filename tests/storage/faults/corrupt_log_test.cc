// The log of a killed server: a flipped bit is reported, an incomplete end is not.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "storage/sqlite/opening_check.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::corrupt_log_test {
namespace {

using Catch::Contains;

constexpr std::uint32_t kPageBytes = 16384;
constexpr std::size_t kHeaderBytes = 32;
constexpr std::size_t kFrameBytes = 24 + kPageBytes;
// With this number, the fields of the commit frame of the last but one transaction are in one
// sector. Otherwise ReadLog cannot distinguish a flipped bit in that frame from a power cut.
constexpr int kClips = 11;

void Write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

// The files of a store that was killed after kClips clips, one transaction each.
struct Killed {
  std::string store;
  std::string log;

  std::size_t frames() const { return (log.size() - kHeaderBytes) / kFrameBytes; }
  // Returns the offset of frame `number`, counted from 1.
  static std::size_t Frame(std::size_t number) { return kHeaderBytes + (number - 1) * kFrameBytes; }
  // Returns the offset of the first frame of the last transaction.
  std::size_t LastTransaction() const {
    std::size_t frame = frames() - 1;
    while (log.compare(Frame(frame) + 4, 4, std::string(4, '\0')) == 0) --frame;
    return Frame(frame + 1);
  }
  void Flip(std::size_t place) { log[place] = static_cast<char>(log[place] ^ 4); }
};

Killed MakeKilled() {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  for (unsigned i = 1; i <= kClips; ++i) REQUIRE_OK(store->AddClip(SampleClip("d", "walk", i)));
  return {ReadFile(file.path()), ReadFile(file.path() + "-wal")};
}

storage::LogContent Read(const std::string& log) {
  const StoreFile file;
  Write(file.path(), log);
  return storage::ReadLog(file.path(), kPageBytes);
}

void Put(const Killed& killed, const StoreFile& file) {
  Write(file.path(), killed.store);
  Write(file.path() + "-wal", killed.log);
}

}  // namespace

TEST_CASE("Log: a flipped bit anywhere before the last transaction is detected", "[storage][log]") {
  const Killed whole = MakeKilled();
  REQUIRE_FALSE(Read(whole.log).is_corrupt);
  REQUIRE(Read(whole.log).page_count > 0);
  std::size_t place = 0;
  SECTION("header: magic") { place = 3; }
  SECTION("header: page size") { place = 10; }
  SECTION("header: salt") { place = 17; }
  SECTION("header: checksum") { place = 30; }
  SECTION("first frame: page number") { place = Killed::Frame(1) + 3; }
  SECTION("frame: salt") { place = Killed::Frame(20) + 9; }
  SECTION("frame: checksum") { place = Killed::Frame(20) + 20; }
  SECTION("frame: page") { place = Killed::Frame(20) + 9000; }
  SECTION("just before the last transaction") { place = whole.LastTransaction() - 1000; }
  Killed flipped = whole;
  flipped.Flip(place);
  const storage::LogContent log = Read(flipped.log);
  CHECK(log.is_corrupt);
  const auto bad = place < kHeaderBytes
                       ? 0
                       : static_cast<std::int64_t>((place - kHeaderBytes) / kFrameBytes + 1);
  CHECK(log.bad_frame == bad);
  const auto after = static_cast<std::int64_t>(whole.frames()) - bad;
  // If the stored checksum itself is bad, the next frame is not counted.
  CHECK(log.lost_frames <= after);
  CHECK(log.lost_frames >= after - 1);
}

TEST_CASE("Log: the log after a power cut is not corrupt", "[storage][log]") {
  Killed killed = MakeKilled();
  SECTION("cut off anywhere") {
    for (std::size_t size = 0; size <= killed.log.size(); size += 4099) {
      REQUIRE_FALSE(Read(killed.log.substr(0, size)).is_corrupt);
    }
  }
  SECTION("a sector of the last transaction was not written") {
    const std::size_t begin = killed.LastTransaction();
    for (std::size_t place = begin; place < killed.log.size(); place += 1024) {
      std::string log = killed.log;
      const std::size_t sector = place / 512 * 512;
      if (sector < begin) continue;
      log.replace(sector, std::min<std::size_t>(512, log.size() - sector), 512, '\0');
      REQUIRE_FALSE(Read(log).is_corrupt);
    }
  }
  SECTION("frames of a former log behind those of this one") {
    const StoreFile file;
    const auto store = file.Open();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    for (unsigned i = 1; i <= 4; ++i) REQUIRE_OK(store->AddClip(SampleClip("d", "walk", i)));
    // The next change restarts the log from its beginning.
    file.Sql("PRAGMA wal_checkpoint(PASSIVE)");
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
    const std::string log = ReadFile(file.path() + "-wal");
    REQUIRE(log.size() > 10 * kFrameBytes);
    REQUIRE_FALSE(Read(log).is_corrupt);
  }
  SECTION("frames of a transaction that was rolled back after the last one") {
    // A shorter transaction overwrote the beginning of a longer one.
    const std::size_t last = killed.LastTransaction();
    const Killed other = MakeKilled();
    std::string log = killed.log;
    log.replace(last, kFrameBytes, other.log, last, kFrameBytes);
    REQUIRE_FALSE(Read(log).is_corrupt);
  }
}

TEST_CASE(
    "SqliteMotionStore: a corrupt log is reported at opening and by verify until its copy is "
    "deleted",
    "[storage][log]") {
  Killed killed = MakeKilled();
  killed.Flip(Killed::Frame(killed.frames() / 2) + 5000);
  const StoreFile file;
  Put(killed, file);
  const std::string copy = file.path() + "-corrupt-wal";
  const std::string expected = "the log '" + file.path() + "-wal' is corrupt at its frame " +
                               std::to_string(killed.frames() / 2) + ": SQLite drops " +
                               std::to_string(killed.frames() - killed.frames() / 2) +
                               " valid frames after it, with ";
  {
    const auto store = file.Open();
    REQUIRE(Require(store->ListClips("d", {})).size() < kClips);
    REQUIRE(store->maintenance().FoundAtOpening().size() == 1);
    REQUIRE_THAT(Findings(*store), Contains(expected) && Contains("delete '" + copy + "'"));
    REQUIRE_OK(store->AddClip(SampleClip("d", "new", 100)));
  }
  REQUIRE(ReadFile(copy) == killed.log);
  REQUIRE_THAT(Findings(*file.Open()), Contains(expected));
  std::filesystem::remove(copy);
  REQUIRE(Findings(*file.Open()).empty());
}

TEST_CASE("SqliteMotionStore: an intact log and an incomplete one are not reported",
          "[storage][log]") {
  Killed killed = MakeKilled();
  const std::size_t torn = GENERATE(0, 1);
  killed.log.resize(killed.log.size() - torn * kPageBytes / 2);
  const StoreFile file;
  Put(killed, file);
  const auto store = file.Open();
  REQUIRE(Require(store->ListClips("d", {})).size() == kClips - torn);
  REQUIRE(Findings(*store).empty());
  REQUIRE_FALSE(std::filesystem::exists(file.path() + "-corrupt-wal"));
}

}  // namespace motiondb::tests::corrupt_log_test
