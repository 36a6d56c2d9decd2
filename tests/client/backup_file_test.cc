#include "client/backup_file.h"

#include <openssl/sha.h>
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests {
namespace {

using client::BackupFile;

// With the checksum that a backup ends with.
std::string Sealed(const std::string& bytes) {
  std::string digest(SHA256_DIGEST_LENGTH, '\0');
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
         reinterpret_cast<unsigned char*>(digest.data()));
  return bytes + digest;
}

int FileCount(const TemporaryFolder& folder) {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    ++count;
  }
  return count;
}

unsigned Mode(const std::filesystem::path& path) {
  struct stat status {};
  REQUIRE(stat(path.c_str(), &status) == 0);
  return status.st_mode & 0777U;
}

TEST_CASE("BackupFile: two to one file do not mix", "[client]") {
  const TemporaryFolder folder;
  const std::string first = Sealed(std::string(100'000, 'a'));
  const std::string second = Sealed(std::string(70'000, 'b'));
  const bool overwrite = GENERATE(true, false);
  CAPTURE(overwrite);
  {
    BackupFile one, other;
    REQUIRE(one.Open(folder / "copy", overwrite).ok());
    REQUIRE(one.Append(first.substr(0, 50'000)).ok());
    REQUIRE(other.Open(folder / "copy", overwrite).ok());
    REQUIRE(other.Append(second).ok());
    REQUIRE(one.Append(first.substr(50'000)).ok());
    REQUIRE(one.Complete().ok());
    CHECK(ReadFile(folder / "copy") == first);
    // The later one takes its place only where it was told to.
    CHECK(other.Complete().code() ==
          (overwrite ? absl::StatusCode::kOk : absl::StatusCode::kAlreadyExists));
  }
  CHECK(ReadFile(folder / "copy") == (overwrite ? second : first));
  CHECK(FileCount(folder) == 1);
}

TEST_CASE("BackupFile: is its owner's alone, whatever there was", "[client]") {
  const TemporaryFolder folder;
  for (const char* const name : {"copy", "copy.part"}) {
    chmod(folder.Write(name, "stale").c_str(), 0666);
  }
  BackupFile file;
  REQUIRE(file.Open(folder / "copy", /*overwrite=*/true).ok());
  REQUIRE(file.Append(Sealed("bytes")).ok());
  REQUIRE(file.Complete().ok());
  CHECK(Mode(folder / "copy") == 0600);
  CHECK(ReadFile(folder / "copy.part") == "stale");
}

TEST_CASE("BackupFile: one that is damaged or broken off leaves nothing", "[client]") {
  const TemporaryFolder folder;
  {
    BackupFile file;
    REQUIRE(file.Open(folder / "copy", false).ok());
    REQUIRE(file.Append(Sealed("bytes") + "x").ok());
    CHECK(file.Complete().code() == absl::StatusCode::kDataLoss);
  }
  CHECK(FileCount(folder) == 0);
  BackupFile nowhere;
  CHECK(nowhere.Open(folder / "none" / "copy", false).code() == absl::StatusCode::kUnknown);
}

}  // namespace
}  // namespace motiondb::tests
