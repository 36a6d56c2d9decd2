#include "server/engine/operation_book.h"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <sstream>

#include "core/model/model.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/gated_store.h"

namespace motiondb::server {
namespace {

using storage::OperationState;

class Book {
 public:
  Book()
      : store_(std::make_unique<tests::GatedStore>(*storage::SqliteMotionStore::Open(":memory:"),
                                                   std::make_shared<tests::Gate>(),
                                                   std::make_shared<tests::Gate>(), disk_)),
        book_(*store_) {
    REQUIRE(store_->CreateDatabase({.name = "db", .marker_set = "source"}).ok());
  }
  OperationBook* operator->() { return &book_; }
  storage::MotionStore& store() { return *store_; }
  tests::FullDisk& disk() { return *disk_; }

 private:
  const std::shared_ptr<tests::FullDisk> disk_ = std::make_shared<tests::FullDisk>();
  std::unique_ptr<storage::MotionStore> store_;
  OperationBook book_;
};

TEST_CASE("OperationBook: states are stored, progress is not", "[server]") {
  Book book;
  const std::string id = book->Create("db")->id;
  CHECK(book.store().GetOperation(id)->state == OperationState::kPending);
  book->Start(id);
  book->Advance(id, 0.5, "tree, layer 7");
  CHECK(book->Get(id)->progress == 0.5);
  CHECK(book->Get(id)->stage == "tree, layer 7");
  CHECK(book.store().GetOperation(id)->state == OperationState::kRunning);
  CHECK(book.store().GetOperation(id)->progress == 0);
  CHECK(book->List("db", "", 10)->front().progress == 0.5);
  book->Succeed(id, 3);
  CHECK(book.store().GetOperation(id)->state == OperationState::kSucceeded);
  CHECK(book->Get(id)->model_version == 3);
  CHECK(book->Get(id)->progress == 1);
}

TEST_CASE("OperationBook: a failure keeps its code and message", "[server]") {
  Book book;
  const std::string id = book->Create("db")->id;
  book->Fail(id, absl::DataLossError("clip 'a' is damaged"));
  const auto record = *book->Get(id);
  CHECK(record.state == OperationState::kFailed);
  CHECK(record.error_code == static_cast<int>(absl::StatusCode::kDataLoss));
  CHECK(record.error_message == "clip 'a' is damaged");
}

TEST_CASE("OperationBook: what is done stays as it is", "[server]") {
  Book book;
  const std::string id = book->Create("db")->id;
  CHECK(book->Cancel(id).ok());
  book->Succeed(id, 1);
  CHECK(book->Get(id)->state == OperationState::kCancelled);
}

TEST_CASE("OperationBook: a watcher is called once, with the end", "[server]") {
  Book book;
  const std::string id = book->Create("db")->id;
  int calls = 0;
  OperationState seen = OperationState::kPending;
  const auto watcher = [&](const storage::OperationRecord& record) {
    ++calls;
    seen = record.state;
  };
  CHECK(book->Watch(id, watcher) != 0);
  const auto unwatched = book->Watch(id, [](const auto&) { FAIL("was unwatched"); });
  book->Unwatch(id, unwatched);
  book->Start(id);
  book->Advance(id, 0.1, "reading");
  CHECK(calls == 0);
  book->Succeed(id, 1);
  CHECK(calls == 1);
  CHECK(seen == OperationState::kSucceeded);
  CHECK(book->Watch(id, watcher) == 0);
  CHECK(book->Watch("no-such-operation", watcher) == 0);
}

TEST_CASE("OperationBook: a stopping server lets nobody wait", "[server]") {
  Book book;
  const std::string id = book->Create("db")->id;
  int calls = 0;
  book->Watch(id, [&](const auto&) { ++calls; });
  book->ReleaseWaiters();
  CHECK(calls == 1);
  CHECK(book->Watch(id, [&](const auto&) { ++calls; }) == 0);
}

TEST_CASE("OperationBook: ids differ and the newest comes first", "[server]") {
  Book book;
  std::set<std::string> ids;
  std::string last;
  for (int i = 0; i < 50; ++i) ids.insert(last = book->Create("db")->id);
  CHECK(ids.size() == 50);
  CHECK(book->List("db", "", 1)->front().id == last);
  CHECK(book->List("", "", 100)->size() == 50);
  CHECK(absl::IsNotFound(book->Get("x").status()));
  CHECK(absl::IsNotFound(book->Create("no-such-database").status()));
}

// The server's log while it lives.
class Log {
 public:
  Log() {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_st>(text_)));
  }
  ~Log() { spdlog::set_default_logger(former_); }
  int line_count() const {
    const std::string text = text_.str();
    return static_cast<int>(std::ranges::count(text, '\n'));
  }

 private:
  std::ostringstream text_;
  const std::shared_ptr<spdlog::logger> former_ = spdlog::default_logger();
};

TEST_CASE("OperationBook: without room in the store it lives in memory, and the log says so once",
          "[server]") {
  const Log log;
  Book book;
  book.disk().Set(tests::FullDisk::Lacks::kRoomForOperations);
  const auto created = book->Create("db");
  INFO(created.status().ToString());
  REQUIRE(created.ok());
  CHECK(log.line_count() == 1);
  CHECK(book->Get(created->id)->state == OperationState::kPending);
  CHECK(absl::IsNotFound(book.store().GetOperation(created->id).status()));
  int called = 0;
  CHECK(book->Watch(created->id, [&](const storage::OperationRecord&) { ++called; }) != 0);
  book->Start(created->id);
  CHECK(book->Get(created->id)->state == OperationState::kRunning);

  SECTION("there is room before it ends") {
    book.disk().Set(tests::FullDisk::Lacks::kNothing);
    book->Succeed(created->id, 2);
    CHECK(book.store().GetOperation(created->id)->state == OperationState::kSucceeded);
  }
  SECTION("there is none to the end") {
    book->Succeed(created->id, 2);
    CHECK(absl::IsNotFound(book.store().GetOperation(created->id).status()));
  }
  CHECK(called == 1);
  CHECK(book->Get(created->id)->state == OperationState::kSucceeded);
  CHECK(book->Get(created->id)->model_version == 2);
  CHECK(log.line_count() == 1);
}

TEST_CASE("OperationBook: what is no longer wanted when its turn comes changes nothing",
          "[server]") {
  const Log log;
  const core::Cancelled at_once = [] { return true; };
  Book book;
  CHECK(absl::IsCancelled(book->Create("db", at_once).status()));
  CHECK(book->List("db", "", 10)->empty());
  const std::string id = book->Create("db")->id;
  int called = 0;
  book->Watch(id, [&](const storage::OperationRecord&) { ++called; });
  CHECK(absl::IsCancelled(book->Cancel(id, at_once)));
  CHECK(book->Get(id)->state == OperationState::kPending);
  CHECK(called == 0);
  CHECK(book->Cancel(id).ok());
  CHECK(book->Get(id)->state == OperationState::kCancelled);
  CHECK(called == 1);
  CHECK(log.line_count() == 0);
}

TEST_CASE("OperationBook: a deleted database takes its operations along, and nothing is amiss",
          "[server]") {
  const Log log;
  Book book;
  const std::string building = book->Create("db")->id;
  const std::string waiting = book->Create("db")->id;
  int called = 0;
  book->Watch(building, [&](const storage::OperationRecord&) { ++called; });
  REQUIRE(book.store().DeleteDatabase("db").ok());
  book->Start(building);
  book->Succeed(building, 1);
  CHECK(book->Cancel(waiting).ok());
  CHECK(called == 1);
  CHECK(absl::IsNotFound(book->Get(building).status()));
  CHECK(absl::IsNotFound(book->Get(waiting).status()));
  CHECK(log.line_count() == 0);
}

}  // namespace
}  // namespace motiondb::server
