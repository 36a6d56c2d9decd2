#include "client/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <set>

#include "client/cli/model_dump.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::output_file_test {
namespace {

using client::OutputFile;

std::set<std::string> Names(const TemporaryFolder& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

TEST_CASE("OutputFile: gets its name when it is complete", "[client]") {
  const TemporaryFolder folder;
  const std::string bytes(300'000, 'x');
  {
    auto file = OutputFile::Create(folder / "a");
    REQUIRE(file.ok());
    REQUIRE(file->Append(bytes).ok());
    for (const std::string& name : Names(folder)) CHECK(name.starts_with(".motiondb-"));
  }
  CHECK(Names(folder).empty());
  auto file = OutputFile::Create(folder / "a", 0640);
  REQUIRE(file.ok());
  REQUIRE(file->Append(bytes).ok());
  REQUIRE(file->Append("end").ok());
  REQUIRE(file->Commit(/*replace=*/false).ok());
  CHECK(ReadFile(folder / "a") == bytes + "end");
  CHECK(Names(folder) == std::set<std::string>{"a"});
  struct stat status {};
  REQUIRE(stat((folder / "a").c_str(), &status) == 0);
  CHECK((status.st_mode & 0777U & ~0640U) == 0);
}

TEST_CASE("OutputFile: replaces a file or a link, never the target of a link", "[client]") {
  const TemporaryFolder folder;
  folder.Write("victim", "precious");
  folder.Write("plain", "old");
  std::filesystem::create_symlink("victim", folder / "link");
  std::filesystem::create_symlink("nowhere", folder / "dangling");
  for (const char* const name : {"plain", "link", "dangling"}) {
    CAPTURE(name);
    auto kept = OutputFile::Create(folder / name);
    REQUIRE(kept.ok());
    CHECK(absl::IsAlreadyExists(kept->Commit(/*replace=*/false)));
    REQUIRE(client::WriteFileAtomically(folder / name, "new").ok());
    CHECK(std::filesystem::is_regular_file(std::filesystem::symlink_status(folder / name)));
    CHECK(ReadFile(folder / name) == "new");
  }
  CHECK(ReadFile(folder / "victim") == "precious");
  std::filesystem::create_directory(folder / "sub");
  REQUIRE(mkfifo((folder / "fifo").c_str(), 0600) == 0);
  for (const char* const name : {"sub", "fifo"}) {
    CHECK(absl::IsFailedPrecondition(client::WriteFileAtomically(folder / name, "new")));
  }
  CHECK(Names(folder) ==
        std::set<std::string>{"plain", "link", "dangling", "victim", "sub", "fifo"});
}

TEST_CASE("OutputFile: ignores temporary file names of earlier versions", "[client]") {
  const TemporaryFolder folder;
  folder.Write("victim", "precious");
  for (const char* const name : {"plan.bvh.partial", "a.npy.partial"}) {
    std::filesystem::create_symlink("victim", folder / name);
  }
  REQUIRE(client::WriteFileAtomically(folder / "plan.bvh", "new").ok());
  client::NpyWriter npy(folder / "a.npy", client::NpyType::kInt32, {1});
  npy.Append(7);
  REQUIRE(npy.Finish().ok());
  CHECK(ReadFile(folder / "victim") == "precious");
}

TEST_CASE("OutputFile: detects the same contents", "[client]") {
  const TemporaryFolder folder;
  const std::string bytes(200'000, 'x');
  folder.Write("same", bytes + "y");
  folder.Write("other", bytes + "z");
  folder.Write("short", bytes);
  std::filesystem::create_symlink("same", folder / "link");
  const auto is_there = [&](const char* name) {
    auto file = OutputFile::Create(folder / name);
    REQUIRE((file.ok() && file->Append(bytes + "y").ok()));
    return *file->HasSameContent();
  };
  CHECK(is_there("same"));
  for (const char* const name : {"other", "short", "link", "none"}) CHECK_FALSE(is_there(name));
}

TEST_CASE("OutputFile: reports write errors and leaves no file", "[client]") {
  const TemporaryFolder folder;
  CHECK(absl::IsUnknown(OutputFile::Create(folder / "none" / "a").status()));
  CHECK(absl::IsUnknown(client::WriteFileAtomically(folder / std::string(300, 'x'), "bytes")));
  CHECK(Names(folder).empty());
}

TEST_CASE("OutputFile: file names that a server must not send", "[client]") {
  for (const char* const name : {"walk.bvh", "07_01.amc", "M\xC3\xBCller 2.c3d", "a..b", "a-b"}) {
    CHECK(client::CheckFileNameFromServer(name).ok());
  }
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."), std::string(".bashrc"),
        std::string("-rf.bvh"), std::string("a/b"), std::string("/a"), std::string("..\\a"),
        std::string("a\nb"), std::string("a\0b", 3), std::string("a\xE2\x80\xAE"),
        std::string("\xff")}) {
    CAPTURE(name);
    CHECK(absl::IsDataLoss(client::CheckFileNameFromServer(name)));
  }
}

TEST_CASE("CheckCanWrite: finds what writing would find, and changes nothing", "[client]") {
  const TemporaryFolder folder;
  const auto old = folder.Write("old", "content");
  std::filesystem::create_directory(folder / "folder");
  std::filesystem::create_symlink("nowhere", folder / "link");
  const std::set<std::string> before = Names(folder);
  const std::filesystem::path long_name = folder / std::string(300, 'x');
  for (const std::filesystem::path& bad : std::vector<std::filesystem::path>{
           folder / "folder", folder / "none/new", old / "new", long_name, "/dev/null"}) {
    CAPTURE(bad);
    const absl::Status checked = client::CheckCanWrite({old, bad});
    CHECK(!checked.ok());
    CHECK_THAT(std::string(checked.message()), Catch::Contains(bad.string()));
    CHECK(!client::WriteFileAtomically(bad, "x").ok());
  }
  CHECK(client::CheckCanWrite({old, folder / "new", folder / "link", ""}).ok());
  CHECK(Names(folder) == before);
  CHECK(ReadFile(old) == "content");
}

}  // namespace
}  // namespace motiondb::tests::output_file_test
