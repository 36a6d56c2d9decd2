#include <motiondb/client.h>
#include <motiondb/v1/clip.pb.h>

#include <catch2/catch.hpp>

#include "tests/client/connect.h"
#include "tests/client/fake_server.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::client_files_test {
namespace {

using client::Client;

// All byte values, without a short period.
std::string Bytes(size_t count) {
  std::string bytes(count, '\0');
  for (size_t i = 0; i < count; ++i) bytes[i] = static_cast<char>((i * 31 + i / 257) & 0xFF);
  return bytes;
}

v1::ExportClipResponse Header(const std::string& file, const std::string& skeleton = "") {
  v1::ExportClipResponse message;
  message.mutable_header()->mutable_clip()->set_file_name(file);
  message.mutable_header()->set_skeleton_file_name(skeleton);
  return message;
}

v1::ExportClipResponse FileBlock(const std::string& bytes) {
  v1::ExportClipResponse message;
  message.set_file_block(bytes);
  return message;
}

v1::ExportClipResponse SkeletonBlock(const std::string& bytes) {
  v1::ExportClipResponse message;
  message.set_skeleton_block(bytes);
  return message;
}

TEST_CASE("Ingest: a file is sent as a header and blocks of at most 1 MiB", "[client]") {
  FakeServer server;
  v1::IngestClipResponse answer;
  answer.mutable_clip()->set_name("databases/walks/clips/07_01");
  server.Answer("IngestClip", answer);
  const TemporaryFolder folder;
  const std::string file = Bytes((2 << 20) + 17), skeleton = Bytes(100);
  const auto amc = folder.Write("07_01.amc", file);
  const auto asf = folder.Write("07.asf", skeleton);
  v1::IngestClipHeader header;
  header.set_parent("databases/walks");
  header.set_label("walk");
  const Client client = ConnectTo(server.address());
  const auto response = client.IngestFile(header, amc, asf);
  REQUIRE(response.ok());
  CHECK(response->clip().name() == "databases/walks/clips/07_01");

  const auto messages = server.Requests<v1::IngestClipRequest>("IngestClip");
  REQUIRE(messages.size() == 5);
  CHECK(messages[0].header().parent() == "databases/walks");
  CHECK(messages[0].header().label() == "walk");
  CHECK(messages[0].header().file_name() == "07_01.amc");
  CHECK(messages[0].header().skeleton_file_name() == "07.asf");
  std::string file_received, skeleton_received;
  for (const auto& message : messages) {
    CHECK(message.file_block().size() <= 1 << 20);
    file_received += message.file_block();
    skeleton_received += message.skeleton_block();
  }
  CHECK(file_received == file);
  CHECK(skeleton_received == skeleton);
}

TEST_CASE("Ingest: bytes in memory are sent as a header and blocks", "[client]") {
  FakeServer server;
  server.Answer("IngestClip", v1::IngestClipResponse());
  v1::IngestClipHeader header;
  header.set_file_name("walk.bvh");
  const Client client = ConnectTo(server.address());
  REQUIRE(client.IngestBytes(header, "HIERARCHY").ok());
  const auto messages = server.Requests<v1::IngestClipRequest>("IngestClip");
  REQUIRE(messages.size() == 2);
  CHECK(messages[0].header().file_name() == "walk.bvh");
  CHECK(messages[1].file_block() == "HIERARCHY");
}

TEST_CASE("Ingest: a missing file sends nothing", "[client]") {
  FakeServer server;
  const TemporaryFolder folder;
  const Client client = ConnectTo(server.address());
  const absl::Status missing = client.IngestFile({}, folder / "none.bvh").status();
  CHECK(missing.code() == absl::StatusCode::kNotFound);
  CHECK_THAT(std::string(missing.message()), Catch::Contains("none.bvh"));
  CHECK(client.IngestFile({}, folder.path()).status().code() == absl::StatusCode::kInvalidArgument);
  CHECK(server.Requests<v1::IngestClipRequest>("IngestClip").empty());
}

TEST_CASE("Ingest: returns the error of the server", "[client]") {
  FakeServer server;
  server.Fail("IngestClip", 3, "bad.bvh:7: expected CHANNELS");
  const Client client = ConnectTo(server.address());
  const absl::Status status = client.IngestBytes({}, Bytes(5 << 20)).status();
  CHECK(status.code() == absl::StatusCode::kInvalidArgument);
  CHECK(std::string(status.message()) == "bad.bvh:7: expected CHANNELS");
}

TEST_CASE("Export: blocks are written to the ingested files", "[client]") {
  FakeServer server;
  server.Answer("ExportClip", Header("07_01.amc", "07.asf"), FileBlock("ab"), FileBlock("cd"),
                SkeletonBlock("xyz"));
  const Client client = ConnectTo(server.address());
  const auto clip = client.ExportClip({});
  REQUIRE(clip.ok());
  CHECK(clip->file_name == "07_01.amc");
  CHECK(clip->file == "abcd");
  CHECK(clip->skeleton_file_name == "07.asf");
  CHECK(clip->skeleton == "xyz");

  const TemporaryFolder folder;
  const auto out = folder / "new/folder";
  REQUIRE(client.ExportClipToDirectory({}, out).ok());
  CHECK(ReadFile(out / "07_01.amc") == "abcd");
  CHECK(ReadFile(out / "07.asf") == "xyz");
}

TEST_CASE("Export: replaces different contents only with overwrite; accepts the same contents",
          "[client]") {
  FakeServer server;
  server.Answer("ExportClip", Header("07_01.amc", "07.asf"), FileBlock("new"),
                SkeletonBlock("asf"));
  const Client client = ConnectTo(server.address());
  const TemporaryFolder folder;
  folder.Write("07.asf", "asf");
  folder.Write("07_01.amc", "old");
  CHECK(client.ExportClipToDirectory({}, folder.path()).status().code() ==
        absl::StatusCode::kAlreadyExists);
  CHECK(ReadFile(folder / "07_01.amc") == "old");
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2);
  CHECK(client.ExportClipToDirectory({}, folder.path(), true).ok());
  CHECK(ReadFile(folder / "07_01.amc") == "new");
}

TEST_CASE("Export: rejects file names of the server that leave the folder", "[client]") {
  const TemporaryFolder folder;
  for (const char* name : {"", ".", "..", "../evil.bvh", "/tmp/evil.bvh", "a/b.bvh", ".bashrc",
                           "-rf.bvh", "a\x1b.bvh"}) {
    FakeServer server;
    server.Answer("ExportClip", Header(name), FileBlock("x"));
    const Client client = ConnectTo(server.address());
    CAPTURE(name);
    CHECK(client.ExportClipToDirectory({}, folder / "inner").status().code() ==
          absl::StatusCode::kDataLoss);
  }
  CHECK(std::filesystem::is_empty(folder / "inner"));
}

TEST_CASE("Export: a link in the folder is not followed", "[client]") {
  FakeServer server;
  server.Answer("ExportClip", Header("07_01.amc"), FileBlock("new"));
  const Client client = ConnectTo(server.address());
  const TemporaryFolder folder;
  const auto victim = folder.Write("victim", "precious");
  const auto out = folder / "out";
  std::filesystem::create_directory(out);
  std::filesystem::create_symlink(victim, out / "07_01.amc.partial");
  REQUIRE(client.ExportClipToDirectory({}, out).ok());
  CHECK(ReadFile(out / "07_01.amc") == "new");
  std::filesystem::remove(out / "07_01.amc");
  std::filesystem::create_symlink(victim, out / "07_01.amc");
  CHECK(absl::IsAlreadyExists(client.ExportClipToDirectory({}, out).status()));
  CHECK(std::filesystem::is_symlink(out / "07_01.amc"));
  REQUIRE(client.ExportClipToDirectory({}, out, true).ok());
  CHECK(!std::filesystem::is_symlink(out / "07_01.amc"));
  CHECK(ReadFile(victim) == "precious");
}

TEST_CASE("Export: two files with the same name are refused", "[client]") {
  FakeServer server;
  server.Answer("ExportClip", Header("a.bvh", "a.bvh"), FileBlock("x"), SkeletonBlock("y"));
  const TemporaryFolder folder;
  CHECK(absl::IsDataLoss(
      ConnectTo(server.address()).ExportClipToDirectory({}, folder.path()).status()));
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("Export: a broken stream is DATA_LOSS and leaves no file", "[client]") {
  const TemporaryFolder folder;
  FakeServer server;
  server.Answer("ExportClip", FileBlock("x"));
  server.Answer("ExportClip", Header("a.bvh"), Header("a.bvh"));
  server.Push("ExportClip", {});
  server.Push("ExportClip", {14, "going down", "", {Header("a.bvh").SerializeAsString()}});
  const Client client = ConnectTo(server.address());
  for (int i = 0; i < 3; ++i) {
    CHECK(client.ExportClipToDirectory({}, folder.path()).status().code() ==
          absl::StatusCode::kDataLoss);
  }
  CHECK(client.ExportClipToDirectory({}, folder.path()).status().code() ==
        absl::StatusCode::kUnavailable);
  CHECK(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace motiondb::tests::client_files_test
