// WatchDatabase, and queries that require a revision.
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "motiondb/v1/segment.grpc.pb.h"
#include "tests/server/rpc/refusal.h"
#include "tests/server/rpc/trained_server.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::watch_test {
namespace {

// A watch stream, read until its client is up to date.
class Watch {
 public:
  Watch(TestServer& server, std::int64_t after) : stub_(server.NewStub<v1::DatabaseService>()) {
    v1::WatchDatabaseRequest request;
    request.set_name("databases/db");
    request.set_after_revision(after);
    context_.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    reader_ = stub_->WatchDatabase(&context_, request);
  }
  ~Watch() {
    if (ended_) return;
    context_.TryCancel();
    reader_->Finish();
  }

  // Reads changes until the server has no further one. Keeps what they say.
  std::vector<v1::WatchDatabaseResponse> Read() {
    std::vector<v1::WatchDatabaseResponse> changes;
    v1::WatchDatabaseResponse message;
    while (reader_->Read(&message)) {
      CHECK(message.revision() >= revision_);
      revision_ = message.revision();
      if (message.change_case() != v1::WatchDatabaseResponse::CHANGE_NOT_SET) {
        changes.push_back(message);
      }
      if (message.up_to_date()) return changes;
    }
    status_ = reader_->Finish();
    ended_ = true;
    return changes;
  }

  std::int64_t revision() const { return revision_; }
  bool ended() const { return ended_; }
  const grpc::Status& status() const { return status_; }

 private:
  std::unique_ptr<v1::DatabaseService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::WatchDatabaseResponse>> reader_;
  std::int64_t revision_ = 0;
  bool ended_ = false;
  grpc::Status status_;
};

// Returns names of clips and segments, and "model" for models.
std::vector<std::string> NamesOf(const std::vector<v1::WatchDatabaseResponse>& changes) {
  std::vector<std::string> names;
  for (const auto& change : changes) {
    if (change.has_clip()) names.push_back(change.clip().name());
    if (change.has_segment()) names.push_back(change.segment().name());
    if (change.change_case() == v1::WatchDatabaseResponse::kModelVersion) names.push_back("model");
    if (!change.deleted().empty()) names.push_back("-" + change.deleted());
  }
  return names;
}

v1::UpdateClipResponse SetTitle(TestServer& server, const std::string& clip,
                                const std::string& title, const std::string& label = "") {
  const auto stub = server.NewStub<v1::ClipService>();
  v1::UpdateClipRequest request;
  request.mutable_clip()->set_name("databases/db/clips/" + clip);
  request.mutable_clip()->set_title(title);
  request.mutable_update_mask()->add_paths("title");
  if (!label.empty()) {
    request.mutable_clip()->set_label(label);
    request.mutable_update_mask()->add_paths("label");
  }
  const auto updated = Ask(*stub, &v1::ClipService::Stub::UpdateClip, request);
  INFO(updated.status.error_message());
  REQUIRE(updated.status.ok());
  return updated.response;
}

TEST_CASE("WatchDatabase: the present state, then each change when it happens", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  Watch watch(server, 0);
  const auto present = watch.Read();
  std::map<std::string, int> count;
  for (const std::string& name : NamesOf(present)) ++count[name];
  CHECK(count["databases/db/clips/walk"] == 1);
  CHECK(count["databases/db/clips/walk/segments/label"] == 1);
  CHECK(count["model"] == 1);
  CHECK(count.size() == 7);  // three clips, their segments, and the model

  const auto updated = SetTitle(server, "walk", "first");
  const auto changed = watch.Read();
  REQUIRE(changed.size() == 1);
  CHECK(changed[0].clip().title() == "first");
  CHECK(changed[0].revision() == updated.revision());

  // A second watch that begins later sees only what it has missed, in its last state.
  SetTitle(server, "walk", "second");
  SetTitle(server, "wave", "third");
  Watch later(server, updated.revision());
  const auto missed = later.Read();
  CHECK(NamesOf(missed) ==
        std::vector<std::string>{"databases/db/clips/walk", "databases/db/clips/wave"});
  CHECK(missed[0].clip().title() == "second");
}

TEST_CASE("WatchDatabase: deletions, the end of the database, and revisions that do not exist",
          "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  Watch watch(server, 0);
  watch.Read();
  const auto clips = server.NewStub<v1::ClipService>();
  v1::DeleteClipRequest remove;
  remove.set_name("databases/db/clips/walk");
  REQUIRE(Ask(*clips, &v1::ClipService::Stub::DeleteClip, remove).status.ok());
  const auto removed = NamesOf(watch.Read());
  REQUIRE_FALSE(removed.empty());
  CHECK(removed[0] == "-databases/db/clips/walk");

  Watch future(server, 1'000'000);
  future.Read();
  CHECK(future.ended());
  CHECK(ViolatedFields(future.status()) == "after_revision");

  const auto databases = server.NewStub<v1::DatabaseService>();
  v1::DeleteDatabaseRequest whole;
  whole.set_name("databases/db");
  REQUIRE(Ask(*databases, &v1::DatabaseService::Stub::DeleteDatabase, whole).status.ok());
  while (!watch.ended()) watch.Read();
  CHECK(watch.status().error_code() == grpc::StatusCode::NOT_FOUND);
}

TEST_CASE("WatchDatabase: a stopping server ends the stream; the next one continues it",
          "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  auto watch = std::make_unique<Watch>(server, 0);
  watch->Read();
  const std::int64_t revision = watch->revision();
  std::thread reader([&] { watch->Read(); });
  server.Stop();
  reader.join();
  CHECK(watch->status().error_code() == grpc::StatusCode::UNAVAILABLE);
  watch.reset();
  server.Start();
  SetTitle(server, "walk", "after the restart");
  Watch next(server, revision);
  const auto changes = next.Read();
  REQUIRE_FALSE(changes.empty());
  CHECK(changes.back().clip().title() == "after the restart");
}

TEST_CASE("A query with a minimum revision waits for its model", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto queries = server.NewStub<v1::QueryService>();
  auto request = RequestFor<v1::RecognizeRequest>("db");
  request.set_whole(true);
  const auto recognize = [&] {
    auto answer = Ask(*queries, &v1::QueryService::Stub::Recognize, request);
    INFO(answer.status.error_message());
    REQUIRE(answer.status.ok());
    return answer.response;
  };
  CHECK(recognize().windows(0).labels(0).label() == "walk");
  const auto updated = SetTitle(server, "walk", "", "stroll");
  request.set_min_revision(updated.revision());
  const auto after = recognize();
  CHECK(after.windows(0).labels(0).label() == "stroll");
  CHECK(after.windows(0).clips(0).label() == "stroll");
  CHECK(after.revision() >= updated.revision());
  CHECK(after.model_version() >= 1);

  request.set_min_revision(1'000'000);
  const auto future = Ask(*queries, &v1::QueryService::Stub::Recognize, request);
  CHECK(ViolatedFields(future.status) == "min_revision");
}

TEST_CASE("A query waits for a minimum revision until its deadline", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto queries = server.NewStub<v1::QueryService>();
  auto request = RequestFor<v1::RecognizeRequest>("db");
  request.set_whole(true);
  server.gate().Close();
  server.IngestFigure("db", "more", "stroll", {.frame_count = 60, .phase = 2});
  server.gate().AwaitArrival();  // the update of the model reads the clip
  const auto revision = SetTitle(server, "walk", "after the clip").revision();
  request.set_min_revision(revision);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(300));
  v1::RecognizeResponse response;
  CHECK(queries->Recognize(&context, request, &response).error_code() ==
        grpc::StatusCode::DEADLINE_EXCEEDED);
  // The deadline ends the wait, and nothing else.
  server.gate().Open();
  const auto answer = Ask(*queries, &v1::QueryService::Stub::Recognize, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  CHECK(answer.response.revision() >= revision);
}

TEST_CASE("Relabelling refits the model and keeps its tree", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto before = server.Describe("db");
  const auto updated = SetTitle(server, "walk", "", "stroll");
  REQUIRE(IsDone(server.Wait(updated.operation().name())));
  const auto after = server.Describe("db");
  CHECK(after.model_version() > before.model_version());
  CHECK(after.node_count() == before.node_count());
  bool found = false;
  for (const auto& label : after.labels()) found = found || label.label() == "stroll";
  CHECK(found);
  // The next server reads the labels from the store.
  server.Restart();
  auto request = RequestFor<v1::RecognizeRequest>("db");
  request.set_whole(true);
  const auto queries = server.NewStub<v1::QueryService>();
  const auto answer = Ask(*queries, &v1::QueryService::Stub::Recognize, request);
  REQUIRE(answer.status.ok());
  CHECK(answer.response.windows(0).labels(0).label() == "stroll");
  CHECK(server.Describe("db").model_version() == after.model_version());
}

TEST_CASE("A filtered query uses only the clips that pass", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto queries = server.NewStub<v1::QueryService>();
  auto request = RequestFor<v1::RecognizeRequest>("db");
  request.set_whole(true);
  request.set_filter("NOT label = walk");
  const auto answer = Ask(*queries, &v1::QueryService::Stub::Recognize, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  CHECK(answer.response.windows(0).clips_size() == 2);
  CHECK(answer.response.windows(0).labels_size() == 2);
  for (const auto& label : answer.response.windows(0).labels()) CHECK(label.label() != "walk");
  request.set_filter("label = nothing");
  const auto none = Ask(*queries, &v1::QueryService::Stub::Recognize, request);
  CHECK(none.status.error_code() == grpc::StatusCode::FAILED_PRECONDITION);
  CHECK(ReasonOf(none.status) == "FILTER_MATCHES_NOTHING");
  request.set_filter("label == walk");
  CHECK(ViolatedFields(Ask(*queries, &v1::QueryService::Stub::Recognize, request).status) ==
        "filter");
}

}  // namespace
}  // namespace motiondb::tests::watch_test
