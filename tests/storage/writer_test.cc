// The queue of the writer. Catch assertions work on one thread only.
#include "storage/sql/connection/writer.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/storage/queued_work.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"
#include "tests/storage/while_writing.h"

namespace motiondb::tests::writer_test {
namespace {

using storage::Connection;
using storage::Priority;
using Work = QueuedWork::Work;

TEST_CASE("Writer: queued work begins by priority, then in order of submission",
          "[storage][concurrency]") {
  const auto writer = MakeWriter();
  std::string order;  // used by the writer thread, after the joins by this thread
  std::vector<std::unique_ptr<QueuedWork>> submitted;
  {
    WriterHolder holder(*writer);
    const auto submit = [&](Priority priority, char name) {
      submitted.push_back(std::make_unique<QueuedWork>(*writer, priority, [&, name](Connection&) {
        order += name;
        return absl::OkStatus();
      }));
    };
    for (const char name : std::string("abcde")) submit(Priority::kBackground, name);
    for (const char name : std::string("123456789")) submit(Priority::kOrdinary, name);
    for (const char name : std::string("UVWXYZ")) submit(Priority::kUrgent, name);
    holder.Release();
  }
  for (const auto& work : submitted) work->Join();
  // Every fifth piece is background work while ordinary work waits.
  CHECK(order == "UVWXYZ1234a5678b9cde");
}

TEST_CASE("Writer: urgent work overtakes queued work", "[storage][concurrency]") {
  const auto writer = MakeWriter();
  std::string order;
  std::unique_ptr<QueuedWork> urgent;
  std::vector<std::unique_ptr<QueuedWork>> submitted;
  {
    WriterHolder holder(*writer);
    for (const char name : std::string("abcdefgh")) {
      const auto work = [&, name](Connection&) {
        order += name;
        if (name == 'b') {
          urgent = std::make_unique<QueuedWork>(*writer, Priority::kUrgent, [&](Connection&) {
            order += '!';
            return absl::OkStatus();
          });
        }
        return absl::OkStatus();
      };
      submitted.push_back(std::make_unique<QueuedWork>(
          *writer, name < 'e' ? Priority::kBackground : Priority::kOrdinary, work));
    }
    holder.Release();
  }
  for (const auto& work : submitted) work->Join();
  urgent->Join();
  CHECK(order == "efghab!cd");
}

TEST_CASE("Writer: cancellation removes work that has not begun, and nothing else",
          "[storage][concurrency]") {
  const auto writer = MakeWriter();
  const Priority priority = GENERATE(Priority::kUrgent, Priority::kOrdinary, Priority::kBackground);
  int runs = 0;
  const auto work = [&](Connection&) {
    ++runs;
    return absl::OkStatus();
  };
  WriterHolder holder(*writer);
  QueuedWork before(*writer, priority, work);
  QueuedWork withdrawn(*writer, priority, work);
  QueuedWork after(*writer, priority, work);
  withdrawn.Cancel();
  withdrawn.Join();  // while the writer is still held
  CHECK(absl::IsCancelled(withdrawn.status()));
  holder.Release();
  before.Join();
  after.Join();
  CHECK(before.status().ok());
  CHECK(after.status().ok());
  CHECK(runs == 2);

  // Running work continues to its end.
  std::promise<void> begun;
  std::promise<void> release;
  QueuedWork running(*writer, priority, [&](Connection&) -> absl::Status {
    begun.set_value();
    release.get_future().wait();
    return absl::DataLossError("its own result");
  });
  begun.get_future().wait();
  running.Cancel();
  std::this_thread::sleep_for(std::chrono::milliseconds(60));  // time to poll, without effect
  release.set_value();
  running.Join();
  CHECK(absl::IsDataLoss(running.status()));
  // Cancelled from the start.
  CHECK(absl::IsCancelled(writer->Run(
      priority, [] { return true; }, work)));
  CHECK(runs == 2);
}

TEST_CASE("Writer: an exception of work reaches its caller, and the writer continues",
          "[storage][concurrency]") {
  const auto writer = MakeWriter();
  const Work fail = [](Connection&) -> absl::Status { throw std::bad_alloc(); };
  CHECK_THROWS_AS(writer->Run(Priority::kOrdinary, {}, fail), std::bad_alloc);
  const Work too_long = [](Connection&) -> absl::Status { throw std::length_error("too long"); };
  CHECK_THROWS_AS(writer->Run(Priority::kOrdinary, {}, too_long), std::length_error);
  WriterHolder holder(*writer);
  QueuedWork throws(*writer, Priority::kOrdinary, fail);
  QueuedWork next(*writer, Priority::kOrdinary,
                  [](Connection& connection) { return connection.Execute("SELECT 1"); });
  holder.Release();
  throws.Join();
  next.Join();
  CHECK(throws.threw());
  CHECK(next.status().ok());
}

TEST_CASE("Writer: queued work is done before the writer is closed", "[storage][concurrency]") {
  auto writer = MakeWriter();
  int runs = 0;
  std::vector<std::unique_ptr<QueuedWork>> submitted;
  std::jthread closing;
  {
    WriterHolder holder(*writer);
    for (const Priority priority :
         {Priority::kBackground, Priority::kOrdinary, Priority::kUrgent, Priority::kBackground}) {
      submitted.push_back(std::make_unique<QueuedWork>(*writer, priority, [&](Connection&) {
        ++runs;
        return absl::OkStatus();
      }));
    }
    submitted.front()->Cancel();
    submitted.front()->Join();
    closing = std::jthread([&] { writer.reset(); });
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    holder.Release();
  }
  closing.join();
  CHECK(runs == 3);
  CHECK(absl::IsCancelled(submitted.front()->status()));
  for (std::size_t i = 1; i < submitted.size(); ++i) {
    submitted[i]->Join();
    CHECK(submitted[i]->status().ok());
  }
}

TEST_CASE("Writer: each of many callers gets the result of its own work",
          "[storage][concurrency]") {
  constexpr unsigned kCallers = 8;
  constexpr int kRounds = 200;
  const auto writer = MakeWriter();
  REQUIRE_OK(writer->Run(Priority::kOrdinary, {}, [](Connection& connection) {
    return connection.Execute("CREATE TABLE done (caller INTEGER)");
  }));
  std::atomic<int> wrong = 0;
  std::vector<int> done(kCallers);
  {
    std::vector<std::jthread> callers;
    for (unsigned c = 0; c < kCallers; ++c) {
      callers.emplace_back([&, c] {
        std::mt19937 random(c);
        for (int r = 0; r < kRounds; ++r) {
          bool ran = false;
          const auto status = writer->Run(
              static_cast<Priority>(random() % 3),
              [left = static_cast<int>(random() % 3)]() mutable { return left-- == 0; },
              [&](Connection& connection) {
                ran = true;
                return connection.Query("INSERT INTO done VALUES (?)", c).Run();
              });
          if (ran ? !status.ok() : !absl::IsCancelled(status)) ++wrong;
          done[c] += ran ? 1 : 0;
        }
      });
    }
  }
  CHECK(wrong == 0);
  for (unsigned c = 0; c < kCallers; ++c) {
    CHECK(done[c] > 0);
    CHECK(Require(writer->Run(Priority::kOrdinary, {}, [&](Connection& connection) {
            return connection.QueryInteger("SELECT count(*) FROM done WHERE caller = " +
                                           std::to_string(c));
          })) == done[c]);
  }
}

TEST_CASE("SqliteMotionStore: a revocation overtakes changes that were queued earlier",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->access().AddToken({.id = "stolen"}));
  REQUIRE_OK(store->PutOperation(SampleOperation("d", "op")));
  const storage::AuditRecord created{.method = "Create"};
  const storage::AuditRecord revoked{.method = "Revoke"};
  std::atomic<int> queued = 0;
  const auto count = [&] {
    return [&queued, is_first = true]() mutable {
      if (std::exchange(is_first, false)) ++queued;
      return false;
    };
  };
  std::atomic<int> failures = 0;
  std::vector<std::jthread> callers;
  const auto call = [&](const std::function<absl::Status()>& change) {
    const int before = queued;
    callers.emplace_back([&failures, change] { failures += change().ok() ? 0 : 1; });
    while (queued == before) std::this_thread::yield();
  };
  WithBlockedWriter(*store, SampleClip("d", "holder", 1), [&] {
    call([&] { return store->CreateDatabase(SampleDatabase("e"), {&created, count()}); });
    call([&] { return store->access().RevokeToken("stolen", 1, {&revoked, count()}).status(); });
    call([&] { return store->access().AddAuditRecord({.method = "Record"}, count()); });
    auto cancelled = SampleOperation("d", "op");
    cancelled.state = storage::OperationState::kCancelled;
    call([&, cancelled] { return store->PutOperation(cancelled, count()); });
  });
  callers.clear();
  CHECK(failures == 0);
  std::vector<std::string> order;  // newest first
  for (const auto& record : Require(store->access().ListAuditRecords(0, 10))) {
    order.push_back(record.method);
  }
  CHECK(order == std::vector<std::string>{"Create", "Record", "Revoke", "Hold"});
}

}  // namespace
}  // namespace motiondb::tests::writer_test
