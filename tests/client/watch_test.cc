// Client::WatchDatabase and motiondb watch: connections that end, and Ctrl-C.
#include <motiondb/client.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "tests/client/connect.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"

namespace motiondb::tests::watch_test {
namespace {

using Catch::Contains;

constexpr int kUnavailable = 14;
constexpr int kOutOfRange = 11;

v1::WatchDatabaseResponse ClipAt(int revision, const std::string& clip, bool up_to_date = false) {
  v1::WatchDatabaseResponse message;
  message.set_revision(revision);
  message.mutable_clip()->set_name("databases/walks/clips/" + clip);
  message.mutable_clip()->set_label("walk");
  message.set_up_to_date(up_to_date);
  return message;
}

// A connection that sends messages and ends with an error.
FakeServer::Reply Connection(int code, const std::vector<v1::WatchDatabaseResponse>& messages) {
  FakeServer::Reply reply{code, "stopping", "", {}};
  for (const auto& message : messages) reply.messages.push_back(message.SerializeAsString());
  return reply;
}

struct Seen {
  std::vector<std::string> changes;  // "3 a"
  std::int64_t revision = 0;
  absl::Status end;
  int reconnects = 0;
};

Seen WatchAll(const FakeServer& server, std::int64_t after_revision) {
  Seen seen;
  const client::Client client = ConnectTo(server.address());
  v1::WatchDatabaseRequest request;
  request.set_name("databases/walks");
  request.set_after_revision(after_revision);
  client::Watch watch = client.WatchDatabase(
      request, {.on_reconnect = [&](const absl::Status& error, std::chrono::milliseconds) {
        CHECK(absl::IsUnavailable(error));
        ++seen.reconnects;
      }});
  v1::WatchDatabaseResponse message;
  while (watch.Next(message)) {
    if (!message.has_clip()) continue;
    seen.changes.push_back(std::to_string(message.revision()) + " " +
                           message.clip().name().substr(message.clip().name().rfind('/') + 1));
  }
  seen.revision = watch.revision();
  seen.end = watch.Finish();
  return seen;
}

std::vector<std::int64_t> RevisionsAsked(const FakeServer& server) {
  std::vector<std::int64_t> revisions;
  for (const auto& request : server.Requests<v1::WatchDatabaseRequest>("WatchDatabase")) {
    revisions.push_back(request.after_revision());
  }
  return revisions;
}

TEST_CASE("Watch: continues after the last complete transaction, without repetition", "[client]") {
  FakeServer server;
  // Ends within the transaction 4, which is sent again; c has changed again meanwhile.
  server.Push("WatchDatabase",
              Connection(kUnavailable, {ClipAt(3, "a"), ClipAt(4, "b"), ClipAt(4, "c")}));
  server.Push("WatchDatabase",
              Connection(kUnavailable, {ClipAt(4, "b"), ClipAt(4, "d"), ClipAt(5, "c", true)}));
  // An end without an error is an end of the connection, too.
  server.Push("WatchDatabase", Connection(0, {ClipAt(6, "a")}));
  server.Push("WatchDatabase", Connection(kOutOfRange, {ClipAt(6, "a", true)}));
  const Seen seen = WatchAll(server, 2);
  CHECK(seen.changes == std::vector<std::string>{"3 a", "4 b", "4 c", "4 d", "5 c", "6 a"});
  CHECK(RevisionsAsked(server) == std::vector<std::int64_t>{2, 3, 5, 5});
  CHECK(seen.revision == 6);
  CHECK(seen.reconnects == 3);
  CHECK(absl::IsOutOfRange(seen.end));
}

TEST_CASE("Watch: ends with an error that a new connection does not fix", "[client]") {
  FakeServer server;
  server.Fail("WatchDatabase", 5, "database 'walks' does not exist");
  const Seen seen = WatchAll(server, 0);
  CHECK(absl::IsNotFound(seen.end));
  CHECK(seen.reconnects == 0);
}

TEST_CASE("Watch: Cancel ends it from another thread, also while it waits to reconnect",
          "[client]") {
  FakeServer server;
  server.Fail("WatchDatabase", kUnavailable, "stopping");
  const client::Client client = ConnectTo(server.address());
  v1::WatchDatabaseRequest request;
  request.set_name("databases/walks");
  client::Watch watch = client.WatchDatabase(request);
  std::thread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    watch.Cancel();
  });
  v1::WatchDatabaseResponse message;
  CHECK(!watch.Next(message));
  canceller.join();
  CHECK(absl::IsCancelled(watch.Finish()));
  CHECK(!watch.Next(message));
}

TEST_CASE("motiondb watch: a line for each change; reports reconnections", "[client][cli]") {
  FakeServer server;
  v1::WatchDatabaseResponse model, deleted, segment;
  model.set_revision(5);
  model.set_model_version(2);
  segment.set_revision(6);
  segment.mutable_segment()->set_name("databases/walks/clips/a/segments/s");
  segment.mutable_segment()->set_label("box");
  segment.mutable_segment()->set_end_seconds(1);
  deleted.set_revision(7);
  deleted.set_deleted("databases/walks/clips/b");
  deleted.set_up_to_date(true);
  server.Push("WatchDatabase", Connection(kUnavailable, {ClipAt(3, "a"), model}));
  server.Push("WatchDatabase", Connection(kUnavailable, {model, segment, deleted}));
  const auto result =
      RunMotiondb(server.address(), {"watch", "walks", "--from", "2", "--until-current"});
  CHECK(result.exit_code == 0);
  CHECK(result.out ==
        "       3  clip     a                     label 'walk'\n"
        "       5  model    2\n"
        "       6  segment  a/s                   action 0.00-1.00 s 'box'\n"
        "       7  deleted  b\n");
  CHECK_THAT(result.err, Contains("stopping") && Contains("; trying again in 0."));
  server.Push("WatchDatabase", Connection(0, {deleted}));
  CHECK_THAT(RunMotiondb(server.address(), {"watch", "walks", "--until-current", "--json"}).out,
             Contains("\"deleted\":\"databases/walks/clips/b\""));
}

}  // namespace
}  // namespace motiondb::tests::watch_test
