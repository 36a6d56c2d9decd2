// Imports by a server: takes, cancellation, and other calls meanwhile.
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "core/export/motion_writer.h"
#include "core/format/motion_file.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::import_calls_test {
namespace {

using grpc::StatusCode;
using WaitTime = std::chrono::steady_clock;

// Runs another program instead of motiondb-import.
class ImportProgram {
 public:
  explicit ImportProgram(const std::string& path) : before_(std::getenv("MOTIONDB_IMPORT")) {
    setenv("MOTIONDB_IMPORT", path.c_str(), 1);
  }
  ~ImportProgram() { setenv("MOTIONDB_IMPORT", before_.c_str(), 1); }
  ImportProgram(const ImportProgram&) = delete;
  ImportProgram& operator=(const ImportProgram&) = delete;

 private:
  const std::string before_;
};

v1::IngestClipHeader ImportHeader(const std::string& file_name, const std::string& take = "") {
  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name(file_name);
  if (!take.empty()) header.mutable_conventions()->set_take(take);
  return header;
}

std::string WalkGlb() {
  const auto read =
      core::ReadMotionFile(core::FileFormat::kBvh, {"walk.bvh", WriteBvh({.frame_count = 90})});
  REQUIRE(read.ok());
  auto written = core::WriteMotion(core::FileFormat::kGltf, read->motion);
  REQUIRE(written.ok());
  return std::move(written->bytes);
}

// The same GLB with its animation under two names.
std::string TwoWalks() {
  constexpr std::size_t kJsonAt = 20;
  const std::string glb = WalkGlb();
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  auto document = nlohmann::json::parse(glb.substr(kJsonAt, length));
  document["animations"][0]["name"] = "walk";
  document["animations"].push_back(document["animations"][0]);
  document["animations"][1]["name"] = "\u00dcbung";
  std::string text = document.dump();
  text.append((4 - text.size() % 4) % 4, ' ');
  std::string two = glb.substr(0, kJsonAt) + text + glb.substr(kJsonAt + length);
  const auto total = static_cast<std::uint32_t>(two.size());
  length = static_cast<std::uint32_t>(text.size());
  std::memcpy(two.data() + 8, &total, sizeof total);
  std::memcpy(two.data() + 12, &length, sizeof length);
  return two;
}

v1::Clip ClipNamed(TestServer& server, const std::string& name) {
  v1::GetClipRequest request;
  request.set_name(name);
  const auto stub = server.NewStub<v1::ClipService>();
  const auto found = Ask(*stub, &v1::ClipService::Stub::GetClip, request);
  INFO(found.status.error_message());
  REQUIRE(found.status.ok());
  return found.response.clip();
}

bool HasChildProcess() { return !(waitpid(-1, nullptr, WNOHANG) < 0 && errno == ECHILD); }

}  // namespace

TEST_CASE("IngestClip: each take is a clip, and can be replaced and derived again",
          "[server][import]") {
  TestServer server;
  server.CreateDatabase("db");
  const std::string file = TwoWalks();
  v1::IngestClipResponse walk;
  v1::IngestClipResponse other;
  REQUIRE(server.Ingest(ImportHeader("two.glb", "walk"), file, &walk).ok());
  REQUIRE(server.Ingest(ImportHeader("two.glb", "2"), file, &other).ok());
  CHECK(walk.clip().name() == "databases/db/clips/two-walk");
  CHECK(walk.clip().label() == "walk");
  CHECK(other.clip().name() == "databases/db/clips/two-Ubung");
  CHECK(other.clip().label() == "\u00dcbung");
  CHECK(server.Ingest(ImportHeader("two.glb", "1"), file).error_code() ==
        StatusCode::ALREADY_EXISTS);

  v1::IngestClipHeader again = ImportHeader("other-name.glb", "walk");
  again.set_replace(true);
  again.mutable_conventions()->set_metres_per_unit(1.1);
  v1::IngestClipResponse replaced;
  const grpc::Status status = server.Ingest(again, file, &replaced);
  INFO(status.error_message());
  REQUIRE(status.ok());
  CHECK(replaced.clip().name() == walk.clip().name());
  CHECK(replaced.clip().label() == "walk");
  CHECK(replaced.clip().leg_length_m() == Approx(1.1 * walk.clip().leg_length_m()).epsilon(1e-3));

  v1::ReprocessDatabaseRequest request;
  request.set_name("databases/db");
  const auto stub = server.NewStub<v1::DatabaseService>();
  const auto asked = Ask(*stub, &v1::DatabaseService::Stub::ReprocessDatabase, request);
  REQUIRE(asked.status.ok());
  const v1::Operation done = server.Wait(asked.response.operation().name());
  INFO(done.ShortDebugString());
  CHECK(done.state() == v1::OPERATION_STATE_SUCCEEDED);
  const v1::Clip derived = ClipNamed(server, walk.clip().name());
  CHECK(derived.frame_count() == walk.clip().frame_count());
  CHECK(derived.leg_length_m() == Approx(replaced.clip().leg_length_m()));
  CHECK(ClipNamed(server, other.clip().name()).frame_count() == other.clip().frame_count());
}

TEST_CASE("UploadClip: a file that motiondb-import reads, and its points", "[server][import]") {
  TestServer server;
  server.CreateDatabase("db");
  v1::UploadClipRequest request;
  *request.mutable_header() = ImportHeader("walk.glb");
  request.set_file(WalkGlb());
  const auto stub = server.NewStub<v1::ClipService>();
  const auto send = [&] { return Ask(*stub, &v1::ClipService::Stub::UploadClip, request); };
  request.mutable_header()->set_validate_only(true);
  const auto checked = send();
  INFO(checked.status.error_message());
  REQUIRE(checked.status.ok());
  CHECK(checked.response.points_size() > 10);
  request.mutable_header()->set_validate_only(false);
  const auto stored = send();
  INFO(stored.status.error_message());
  REQUIRE(stored.status.ok());
  CHECK(stored.response.clip().name() == "databases/db/clips/walk");
  CHECK(stored.response.clip().frame_count() == checked.response.clip().frame_count());
  CHECK(!stored.response.operation().name().empty());

  request.set_file(TwoWalks());
  request.mutable_header()->set_file_name("two.glb");
  CHECK(send().status.error_message().find("take") != std::string::npos);
  request.mutable_header()->mutable_conventions()->set_take("walk");
  CHECK(send().response.clip().name() == "databases/db/clips/two-walk");
  for (const char* const name : {"bad.glb", "bad.fbx", "bad.dae"}) {
    INFO(name);
    *request.mutable_header() = ImportHeader(name);
    request.set_file("garbage");
    const auto refused = send();
    CHECK(refused.status.error_code() == StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(refused.status) == "file");
  }
}

TEST_CASE("IngestClip: an import that takes long delays no other ingest, and ends when cancelled",
          "[server][import]") {
  server::ServerOptions options;
  options.engine.query_threads = 2;  // one for heavy calls
  TestServer server(options);
  server.CreateDatabase("db");
  const TemporaryDirectory folder;
  const std::string program = folder / "import";
  const std::string started = folder / "started";
  std::ofstream(program) << "#!/bin/sh\ntouch " << started << "\nexec sleep 300\n";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const ImportProgram slow(program);

  grpc::ClientContext context;
  std::future<grpc::Status> importing = std::async(std::launch::async, [&] {
    const auto stub = server.NewStub<v1::ClipService>();
    v1::IngestClipResponse response;
    const auto writer = stub->IngestClip(&context, &response);
    v1::IngestClipRequest message;
    *message.mutable_header() = ImportHeader("slow.glb");
    writer->Write(message);
    message.set_file_block("glTF");
    writer->Write(message);
    writer->WritesDone();
    return writer->Finish();
  });
  const auto latest = WaitTime::now() + std::chrono::minutes(1);
  while (!std::filesystem::exists(started) && WaitTime::now() < latest) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  REQUIRE(std::filesystem::exists(started));

  std::future<grpc::Status> ingesting = std::async(std::launch::async, [&] {
    return server.Ingest(ImportHeader("walk.bvh"), WriteBvh({.frame_count = 90}));
  });
  CHECK(ingesting.wait_for(std::chrono::minutes(1)) == std::future_status::ready);
  CHECK(importing.wait_for(std::chrono::seconds(0)) == std::future_status::timeout);

  context.TryCancel();
  CHECK(importing.get().error_code() == StatusCode::CANCELLED);
  CHECK(ingesting.get().ok());
  const auto end = WaitTime::now() + std::chrono::minutes(1);
  while (HasChildProcess() && WaitTime::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK_FALSE(HasChildProcess());
  CHECK(server.Describe("db").stored_clip_count() == 1);
}

}  // namespace motiondb::tests::import_calls_test
