// motiondb export-database and import-database, and the files of backup and restore.
#include <motiondb/v1/access.pb.h>
#include <motiondb/v1/store.pb.h>
#include <openssl/sha.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::database_file_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

constexpr int kNotFound = 5;
constexpr int kAlreadyExists = 6;
constexpr int kInvalidArgument = 3;

// The bytes of an exported database as a server sends them.
std::string ExportedBytes() {
  std::string bytes("SQLite format 3\0", 16);
  bytes.resize(100'000);
  bytes.replace(68, 4, "mtdb");
  bytes += "mtdbback";
  std::string digest(SHA256_DIGEST_LENGTH, '\0');
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
         reinterpret_cast<unsigned char*>(digest.data()));
  return bytes + digest;
}

// Makes the server send `bytes` in two blocks, then end the call with `code`.
void AnswerExport(FakeServer& server, const std::string& bytes, int code = 0) {
  v1::ExportDatabaseResponse first, second;
  first.set_total_bytes(static_cast<std::int64_t>(bytes.size()));
  first.set_block(bytes.substr(0, bytes.size() / 2));
  second.set_block(bytes.substr(bytes.size() / 2));
  server.Push(
      "ExportDatabase",
      {code, "the server stops", "", {first.SerializeAsString(), second.SerializeAsString()}});
}

std::vector<std::string> NamesIn(const TemporaryFolder& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    names.push_back(entry.path().filename().string());
  }
  return names;
}

// Returns the error of an export to a path, which must fail.
std::string ExportError(const FakeServer& server, const std::filesystem::path& path,
                        const std::vector<std::string>& options = {}) {
  std::vector<std::string> arguments = {"export-database", "walks", path.string()};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const auto result = RunMotiondb(server.address(), arguments);
  CHECK(result.exit_code == 1);
  CHECK(result.out.empty());
  return result.err;
}

std::string ImportError(const FakeServer& server, const std::vector<std::string>& arguments) {
  std::vector<std::string> all = {"import-database"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const auto result = RunMotiondb(server.address(), all);
  CHECK(result.exit_code == 1);
  CHECK(result.out.empty());
  return result.err;
}

TEST_CASE("motiondb export-database: writes a file that appears when it is complete",
          "[client][cli]") {
  const TemporaryFolder folder;
  FakeServer server;
  AnswerExport(server, ExportedBytes());
  const std::string path = (folder / "walks.motiondb").string();
  const bool json = GENERATE(false, true);
  std::vector<std::string> arguments = {"export-database", "walks", path};
  if (json) arguments.push_back("--json");
  const auto result = RunMotiondb(server.address(), arguments);
  CHECK(result.exit_code == 0);
  CHECK(result.out == (json ? "{\"file\":\"" + path + "\",\"total_bytes\":100040}\n"
                            : path + ": 0.1 MB, checksum correct\n"));
  CHECK(folder.Read("walks.motiondb") == ExportedBytes());
  CHECK(NamesIn(folder) == std::vector<std::string>{"walks.motiondb"});
  const auto requests = server.Requests<v1::ExportDatabaseRequest>("ExportDatabase");
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].name() == "databases/walks");
}

TEST_CASE("motiondb export-database: replaces only an exported file, and only with --force",
          "[client][cli]") {
  const TemporaryFolder folder;
  FakeServer server;
  AnswerExport(server, ExportedBytes());
  const auto other = folder.Write("list", "a list of clips");
  const auto exported = folder.Write("walks", ExportedBytes().replace(500, 1, "x"));
  const std::string former = folder.Read("walks");
  CHECK_THAT(ExportError(server, other), Contains("list: already exists"));
  CHECK_THAT(ExportError(server, exported), Contains("walks: already exists"));
  CHECK_THAT(ExportError(server, other, {"--force"}), Contains("is not a backup"));
  CHECK_THAT(ExportError(server, folder.path(), {"--force"}), Contains("is a folder"));
  CHECK(server.Requests<v1::ExportDatabaseRequest>("ExportDatabase").empty());
  CHECK(folder.Read("list") == "a list of clips");
  CHECK(folder.Read("walks") == former);
  const auto forced =
      RunMotiondb(server.address(), {"export-database", "walks", exported.string(), "--force"});
  CHECK(forced.exit_code == 0);
  CHECK(folder.Read("walks") == ExportedBytes());
}

TEST_CASE("motiondb export-database: after an error there is no file", "[client][cli]") {
  const TemporaryFolder folder;
  FakeServer server;
  const auto path = folder / "walks";
  SECTION("the folder does not exist") {
    AnswerExport(server, ExportedBytes());
    CHECK_THAT(ExportError(server, folder / "none" / "walks"), Contains("No such file"));
    CHECK(server.Requests<v1::ExportDatabaseRequest>("ExportDatabase").empty());
  }
  SECTION("the folder cannot be written") {
    if (geteuid() == 0) return;  // root can write every folder
    std::filesystem::create_directory(folder / "read-only");
    std::filesystem::permissions(folder / "read-only", std::filesystem::perms::owner_read);
    AnswerExport(server, ExportedBytes());
    CHECK_THAT(ExportError(server, folder / "read-only" / "walks"), Contains("Permission denied"));
    std::filesystem::remove(folder / "read-only");
  }
  SECTION("the database does not exist") {
    server.Fail("ExportDatabase", kNotFound, "database 'walks' does not exist");
    CHECK_THAT(ExportError(server, path), Contains("database 'walks' does not exist"));
  }
  SECTION("the call ends early") {
    AnswerExport(server, ExportedBytes(), /*code=*/13);
    CHECK_THAT(ExportError(server, path), Contains("the server stops"));
  }
  SECTION("a byte is wrong, or missing") {
    std::string bytes = ExportedBytes();
    if (GENERATE(true, false)) {
      bytes[5'000] = 'x';
    } else {
      bytes.pop_back();
    }
    AnswerExport(server, bytes);
    CHECK_THAT(ExportError(server, path), Contains("walks: the received backup is corrupt"));
  }
  CHECK(NamesIn(folder).empty());
}

TEST_CASE("motiondb import-database: sends the file and the name", "[client][cli]") {
  const TemporaryFolder folder;
  const std::string path = folder.Write("walks.motiondb", ExportedBytes()).string();
  FakeServer server;
  v1::ImportDatabaseResponse response;
  response.set_name("databases/walks-2026");
  response.set_clip_count(12);
  server.Answer("ImportDatabase", response);
  const std::string as = GENERATE("", "walks-2026", "databases/walks-2026");
  std::vector<std::string> arguments = {"import-database", path};
  if (!as.empty()) arguments.insert(arguments.end(), {"--as", as});
  const auto result = RunMotiondb(server.address(), arguments);
  CHECK(result.exit_code == 0);
  CHECK(result.out == "imported walks-2026, 12 clips\n");
  std::string sent;
  const auto requests = server.Requests<v1::ImportDatabaseRequest>("ImportDatabase");
  for (const auto& request : requests) sent += request.block();
  CHECK(sent == ExportedBytes());
  REQUIRE_FALSE(requests.empty());
  CHECK(requests[0].database_id() == (as.empty() ? "" : "walks-2026"));
  arguments.push_back("--json");
  CHECK_THAT(RunMotiondb(server.address(), arguments).out,
             Contains("\"clip_count\"") && Contains("databases/walks-2026"));
}

TEST_CASE("motiondb import-database: reports what the server refuses", "[client][cli]") {
  const TemporaryFolder folder;
  FakeServer server;
  SECTION("a taken name") {
    server.Fail("ImportDatabase", kAlreadyExists, "database 'walks' already exists");
    const std::string path = folder.Write("walks", ExportedBytes()).string();
    CHECK_THAT(ImportError(server, {path}), Contains("database 'walks' already exists"));
    CHECK_THAT(ImportError(server, {path, "--as", "walks"}), Contains("already exists"));
  }
  SECTION("a broken file") {
    server.Fail("ImportDatabase", kInvalidArgument, "the exported database is corrupt");
    const std::string bytes = GENERATE("", "x", "SQLite format 3");
    CHECK_THAT(ImportError(server, {folder.Write("broken", bytes).string()}),
               Contains("the exported database is corrupt"));
  }
}

TEST_CASE("motiondb import-database: sends nothing that is not a file", "[client][cli]") {
  const TemporaryFolder folder;
  FakeServer server;
  CHECK_THAT(ImportError(server, {(folder / "none").string()}), Contains("none: no such file"));
  CHECK_THAT(ImportError(server, {folder.path().string()}), Contains("is a folder, not a file"));
  CHECK_THAT(ImportError(server, {"/dev/null"}), Contains("is not a regular file"));
  CHECK(server.Requests<v1::ImportDatabaseRequest>("ImportDatabase").empty());
}

TEST_CASE("motiondb backup, restore, export-database and import-database: refuse '-'",
          "[client][cli]") {
  FakeServer server;
  const auto command = GENERATE(values<std::vector<std::string>>(
      {{"backup"}, {"restore"}, {"export-database", "walks"}, {"import-database"}}));
  std::vector<std::string> arguments = command;
  arguments.push_back("-");
  const auto result = RunMotiondb(server.address(), arguments);
  CHECK(result.exit_code == 2);
  CHECK_THAT(result.err, Contains("expected the name of a file, got '-'"));
  CHECK_FALSE(std::filesystem::exists("-"));
}

}  // namespace
}  // namespace motiondb::tests::database_file_command_test
