#include "client/backup_file.h"

#include <openssl/sha.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::backup_file_test {
namespace {

using Catch::Contains;
using client::BackupFile;

// Appends the checksum of a backup.
std::string Sealed(const std::string& bytes) {
  std::string digest(SHA256_DIGEST_LENGTH, '\0');
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
         reinterpret_cast<unsigned char*>(digest.data()));
  return bytes + digest;
}

// The beginning of a store: SQLite's header with the application id.
std::string StoreBytes() {
  std::string bytes("SQLite format 3\0", 16);
  bytes.resize(200);
  return bytes.replace(68, 4, "mtdb");
}

std::string BackupOf(const std::string& pages) { return Sealed(StoreBytes() + pages + "mtdbback"); }

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

TEST_CASE("BackupFile: two concurrent backups to one path do not mix", "[client]") {
  const TemporaryFolder folder;
  const std::string first = BackupOf(std::string(100'000, 'a'));
  const std::string second = BackupOf(std::string(70'000, 'b'));
  const bool overwrite = GENERATE(true, false);
  CAPTURE(overwrite);
  {
    BackupFile backup_a, backup_b;
    REQUIRE(backup_a.Open(folder / "copy", overwrite).ok());
    REQUIRE(backup_a.Append(first.substr(0, 50'000)).ok());
    REQUIRE(backup_b.Open(folder / "copy", overwrite).ok());
    REQUIRE(backup_b.Append(second).ok());
    REQUIRE(backup_a.Append(first.substr(50'000)).ok());
    REQUIRE(backup_a.Complete().ok());
    CHECK(ReadFile(folder / "copy") == first);
    // The second one replaces the file only with `overwrite`.
    CHECK(backup_b.Complete().code() ==
          (overwrite ? absl::StatusCode::kOk : absl::StatusCode::kAlreadyExists));
  }
  CHECK(ReadFile(folder / "copy") == (overwrite ? second : first));
  CHECK(FileCount(folder) == 1);
}

TEST_CASE("BackupFile: only the owner can read it, whatever existed before", "[client]") {
  const TemporaryFolder folder;
  chmod(folder.Write("copy", "").c_str(), 0666);
  chmod(folder.Write("copy.part", "stale").c_str(), 0666);
  BackupFile file;
  REQUIRE(file.Open(folder / "copy", /*overwrite=*/true).ok());
  REQUIRE(file.Append(Sealed("bytes")).ok());
  REQUIRE(file.Complete().ok());
  CHECK(Mode(folder / "copy") == 0600);
  CHECK(ReadFile(folder / "copy.part") == "stale");
}

TEST_CASE("BackupFile: a corrupt or incomplete one leaves no file", "[client]") {
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

std::string Refusal(const std::filesystem::path& path) {
  const auto before = std::filesystem::symlink_status(path).type();
  BackupFile file;
  const absl::Status status = file.Open(path, /*overwrite=*/true);
  CHECK(status.code() == absl::StatusCode::kFailedPrecondition);
  CHECK_THAT(std::string(status.message()), Contains(path.string() + ": "));
  CHECK(std::filesystem::symlink_status(path).type() == before);
  return std::string(status.message());
}

TEST_CASE("BackupFile: replaces only regular files", "[client]") {
  const TemporaryFolder folder;
  REQUIRE(mkfifo((folder / "fifo").c_str(), 0600) == 0);
  CHECK_THAT(Refusal(folder / "fifo"), Contains("is a pipe"));
  CHECK_THAT(Refusal("/dev/null"), Contains("is a device"));
  std::filesystem::create_directory(folder / "sub");
  CHECK_THAT(Refusal(folder / "sub"), Contains("is a folder"));
  std::filesystem::create_symlink("elsewhere", folder / "link");
  CHECK_THAT(Refusal(folder / "link"), Contains("is a symbolic link"));
  sockaddr_un address{AF_UNIX, {}};
  (folder / "sock").string().copy(address.sun_path, sizeof(address.sun_path) - 1);
  const int listening = socket(AF_UNIX, SOCK_STREAM, 0);
  REQUIRE(bind(listening, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0);
  CHECK_THAT(Refusal(folder / "sock"), Contains("is a socket"));
  close(listening);
  CHECK(FileCount(folder) == 4);
}

TEST_CASE("BackupFile: replaces a backup, never a store or another file", "[client]") {
  const TemporaryFolder folder;
  CHECK_THAT(Refusal(folder.Write("list", "a list of clips")), Contains("is not a backup"));
  CHECK_THAT(Refusal(folder.Write("sealed", Sealed("a page and mtdbback"))),
             Contains("is not a backup"));
  CHECK_THAT(Refusal(folder.Write("store", StoreBytes())), Contains("is a motiondb store"));
  const std::string backup = BackupOf("");
  // A server was started on a backup.
  for (const char* const suffix : {"-lock", "-wal"}) {
    const std::string name = std::string("served") + suffix;
    const auto served = folder.Write("served", backup);
    const auto beside = folder.Write(name, "");
    CHECK_THAT(Refusal(served), Contains(beside.string()));
    std::filesystem::remove(beside);
  }
  for (const std::string& bytes : {backup, std::string()}) {
    folder.Write("copy", bytes);
    BackupFile file;
    REQUIRE(file.Open(folder / "copy", /*overwrite=*/true).ok());
    REQUIRE(file.Append(Sealed("new")).ok());
    CHECK(file.Complete().ok());
    CHECK(ReadFile(folder / "copy") == Sealed("new"));
  }
}

TEST_CASE("BackupFile: does not replace a store that appears meanwhile", "[client]") {
  const TemporaryFolder folder;
  BackupFile file;
  REQUIRE(file.Open(folder / "copy", /*overwrite=*/true).ok());
  REQUIRE(file.Append(Sealed("new")).ok());
  folder.Write("copy", StoreBytes());
  CHECK(file.Complete().code() == absl::StatusCode::kFailedPrecondition);
  CHECK(ReadFile(folder / "copy") == StoreBytes());
}

}  // namespace
}  // namespace motiondb::tests::backup_file_test
