// motiondbd as a process: acknowledged changes survive SIGKILL, and SIGTERM drains it.
#include <grpcpp/create_channel.h>
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "tests/support/child_process.h"
#include "tests/support/project_paths.h"
#include "tests/support/stick_figure.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::server_process_test {
namespace {

// A running motiondbd on a free port.
class ServerProcess {
 public:
  explicit ServerProcess(const std::string& store)
      : process_({MotiondbdProgram(), "--store", store, "--listen", "127.0.0.1:0", "--log-level",
                  "error", "--rebuild-delay", "0.05", "--grace-seconds", "5"}) {
    constexpr std::string_view kAnnouncement = "motiondbd: listening on ";
    const std::string line = process_.ReadLine();
    INFO(line);
    REQUIRE(line.starts_with(kAnnouncement));
    address_ = line.substr(kAnnouncement.size());
    channel_ = grpc::CreateChannel(address_, grpc::InsecureChannelCredentials());
  }

  ChildProcess& process() { return process_; }
  const std::string& address() const { return address_; }

  void CreateDatabase() {
    v1::CreateDatabaseRequest request;
    request.set_database_id("db");
    request.mutable_database()->set_marker_set("source");
    request.mutable_database()->set_min_frames(4);
    v1::CreateDatabaseResponse response;
    grpc::ClientContext context;
    REQUIRE(
        v1::DatabaseService::NewStub(channel_)->CreateDatabase(&context, request, &response).ok());
  }

  v1::IngestClipResponse Ingest(const StickFigure& figure) {
    const auto stub = v1::ClipService::NewStub(channel_);
    grpc::ClientContext context;
    v1::IngestClipResponse response;
    const auto writer = stub->IngestClip(&context, &response);
    v1::IngestClipRequest message;
    message.mutable_header()->set_parent("databases/db");
    message.mutable_header()->set_file_name("walk.bvh");
    writer->Write(message);
    message.set_file_block(WriteBvh(figure));
    writer->Write(message);
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    INFO(status.error_message());
    REQUIRE(status.ok());
    return response;
  }

  int ClipCount() {
    v1::ListClipsRequest request;
    request.set_parent("databases/db");
    v1::ListClipsResponse response;
    grpc::ClientContext context;
    REQUIRE(v1::ClipService::NewStub(channel_)->ListClips(&context, request, &response).ok());
    return response.clips_size();
  }

  v1::Operation Wait(const std::string& operation) {
    v1::WaitOperationRequest request;
    request.set_name(operation);
    v1::WaitOperationResponse response;
    grpc::ClientContext context;
    const grpc::Status status =
        v1::OperationService::NewStub(channel_)->WaitOperation(&context, request, &response);
    INFO(status.error_message());
    REQUIRE(status.ok());
    return response.operation();
  }

 private:
  ChildProcess process_;
  std::string address_;
  std::shared_ptr<grpc::Channel> channel_;
};

TEST_CASE("ServerProcess: an acknowledged clip survives SIGKILL, and so does its rebuild",
          "[e2e]") {
  TemporaryDirectory directory;
  const std::string store = directory / "store.db";
  std::string operation;
  for (int round = 0; round < 5; ++round) {
    ServerProcess server(store);
    if (round == 0) server.CreateDatabase();
    CHECK(server.ClipCount() == round);
    operation = server.Ingest({.phase = 0.7 * round}).operation().name();
    server.process().Signal(SIGKILL);
    CHECK(server.process().Wait() == 128 + SIGKILL);
  }
  ServerProcess server(store);
  CHECK(server.ClipCount() == 5);
  CHECK(server.Wait(operation).state() == v1::OPERATION_STATE_SUCCEEDED);
}

TEST_CASE("ServerProcess: SIGTERM, SIGINT and SIGHUP drain it", "[e2e]") {
  TemporaryDirectory directory;
  const std::string store = directory / "store.db";
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    ServerProcess server(store);
    if (signal == SIGTERM) server.CreateDatabase();
    server.Ingest({.frame_count = 600, .phase = 0.1 * signal});
    server.process().Signal(signal);
    CHECK(server.process().Wait() == 0);
  }
  ServerProcess server(store);
  CHECK(server.ClipCount() == 3);
}

TEST_CASE("ServerProcess: an ignored SIGHUP stays ignored", "[e2e]") {
  TemporaryDirectory directory;
  const auto former = std::signal(SIGHUP, SIG_IGN);  // as set by nohup
  ServerProcess server(directory / "store.db");
  std::signal(SIGHUP, former);
  server.process().Signal(SIGHUP);
  server.CreateDatabase();
  server.process().Signal(SIGTERM);
  CHECK(server.process().Wait() == 0);
}

TEST_CASE("ServerProcess: only the owner can read its files", "[e2e]") {
  TemporaryDirectory directory;
  const mode_t former = umask(0);
  ServerProcess server(directory / "store.db");
  umask(former);
  server.CreateDatabase();
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(directory / "")) {
    CAPTURE(file.path().string());
    CHECK((file.status().permissions() & std::filesystem::perms(0077)) ==
          std::filesystem::perms::none);
    ++count;
  }
  CHECK(count >= 3);  // store, WAL and lock file
}

TEST_CASE("ServerProcess: a running call ends before the server", "[e2e]") {
  TemporaryDirectory directory;
  ServerProcess server(directory / "store.db");
  server.CreateDatabase();
  const std::string operation = server.Ingest({.frame_count = 6000}).operation().name();
  // A wait may outlive the server: it is answered with the current state.
  v1::Operation seen;
  std::thread waiting([&] { seen = server.Wait(operation); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const auto asked = std::chrono::steady_clock::now();
  server.process().Signal(SIGTERM);
  waiting.join();
  CHECK(seen.name() == operation);
  CHECK(server.process().Wait() == 0);
  CHECK(std::chrono::steady_clock::now() - asked < std::chrono::seconds(5));
}

TEST_CASE("ServerProcess: mistakes end it with a message and an exit code", "[e2e]") {
  TemporaryDirectory directory;
  CHECK(ChildProcess({MotiondbdProgram()}).Wait() != 0);
  CHECK(
      ChildProcess({MotiondbdProgram(), "--store", directory / "a.db", "--threads", "-3"}).Wait() !=
      0);
  CHECK(ChildProcess({MotiondbdProgram(), "--store", directory / "none" + "/a.db"}).Wait() == 1);
  ChildProcess version({MotiondbdProgram(), "--version"});
  CHECK(version.ReadLine().starts_with("motiondbd "));
  CHECK(version.Wait() == 0);
  ServerProcess server(directory / "store.db");
  ChildProcess second({MotiondbdProgram(), "--store", directory / "other.db", "--listen",
                       server.address(), "--log-level", "off"});
  CHECK(second.Wait() == 1);
  // It did not create or upgrade a store that it cannot serve.
  CHECK(!std::filesystem::exists(directory / "other.db"));
  ChildProcess same_store({MotiondbdProgram(), "--store", directory / "store.db", "--listen",
                           "127.0.0.1:0", "--log-level", "off"});
  CHECK(same_store.Wait() == 1);
}

}  // namespace
}  // namespace motiondb::tests::server_process_test
