// Work that shares a transaction of the writer.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/connection/writer.h"
#include "tests/storage/queued_work.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests::shared_transaction_test {
namespace {

using storage::Connection;
using storage::Priority;
using storage::Writer;

// Work that can share a transaction: insertions into a table of unique numbers.
class SharedWork {
 public:
  explicit SharedWork(Writer& writer) : writer_(writer) {
    REQUIRE_OK(writer.Run(Priority::kOrdinary, {}, [](Connection& connection) {
      return connection.Execute("CREATE TABLE t (n INTEGER PRIMARY KEY)");
    }));
  }

  // Submits an insertion and waits until it is queued.
  void Insert(int n, std::int64_t added_bytes, std::function<void()> before = {}) {
    std::promise<void> queued;
    absl::StatusOr<int>* const result =
        results_.emplace_back(std::make_unique<absl::StatusOr<int>>(0)).get();
    callers_.emplace_back([&queued, this, result, n, added_bytes, before = std::move(before)] {
      const auto cancelled = [&, is_first = true]() mutable {
        if (std::exchange(is_first, false)) queued.set_value();
        return false;
      };
      const auto insert = [&](Connection& connection) -> absl::StatusOr<int> {
        if (before) before();
        MOTIONDB_RETURN_IF_ERROR(connection.Query("INSERT INTO t VALUES (?)", n).Run());
        return n;
      };
      try {
        *result = writer_.RunShared(transact_, added_bytes, cancelled, insert);
      } catch (const std::bad_alloc&) {
        *result = absl::ResourceExhaustedError("thrown");
      }
    });
    queued.get_future().wait();
  }

  // Waits for all callers and returns their results in order of submission.
  std::vector<absl::StatusOr<int>> Results() {
    callers_.clear();
    std::vector<absl::StatusOr<int>> results;
    for (const auto& result : results_) results.push_back(*result);
    return results;
  }
  std::int64_t Count() {
    return Require(writer_.Run(Priority::kOrdinary, {}, [](Connection& connection) {
      return connection.QueryInteger("SELECT count(*) FROM t");
    }));
  }
  // The bytes of each transaction, including failed ones.
  const std::vector<std::int64_t>& transactions() const { return transactions_; }
  std::atomic<bool> loses_commit = false;  // transactions are committed, and return UNAVAILABLE

 private:
  Writer& writer_;
  std::vector<std::int64_t> transactions_;
  const Writer::Transact transact_ = [this](Connection& connection, std::int64_t bytes,
                                            const Writer::Body& body) {
    transactions_.push_back(bytes);
    const absl::Status done =
        storage::InTransaction(connection, storage::Transaction::Kind::kWrite, body);
    return done.ok() && loses_commit ? absl::UnavailableError("the answer is lost") : done;
  };
  std::vector<std::unique_ptr<absl::StatusOr<int>>> results_;
  std::vector<std::jthread> callers_;
};

TEST_CASE("Writer: adjacent work shares a transaction of up to a few megabytes",
          "[storage][concurrency]") {
  const auto writer = MakeWriter();
  SharedWork work(*writer);
  {
    WriterHolder holder(*writer);
    for (int n = 0; n < 5; ++n) work.Insert(n, 1 << 20);
    holder.Release();
  }
  for (const auto& result : work.Results()) CHECK(result.ok());
  CHECK(work.Count() == 5);
  CHECK(work.transactions() == std::vector<std::int64_t>{4 << 20, 1 << 20});
}

TEST_CASE("Writer: failing work in a shared transaction does not affect the rest",
          "[storage][concurrency]") {
  const auto writer = MakeWriter();
  SharedWork work(*writer);
  const bool throws = GENERATE(false, true);
  {
    WriterHolder holder(*writer);
    work.Insert(1, 10);
    work.Insert(2, 20, [&] {
      if (throws) throw std::bad_alloc();
    });
    work.Insert(1, 30);  // fails: 1 exists already
    work.Insert(3, 40);
    holder.Release();
  }
  const auto results = work.Results();
  CHECK(results[0].ok());
  CHECK(results[1].ok() == !throws);
  CHECK_FALSE(results[2].ok());
  CHECK(results[3].ok());
  CHECK(work.Count() == (throws ? 2 : 3));
  CHECK(work.transactions() == std::vector<std::int64_t>{100, 10, 20, 30, 40});
}

TEST_CASE("Writer: after a commit without an answer, no work of a shared transaction runs again",
          "[storage][concurrency]") {
  const auto writer = MakeWriter();
  SharedWork work(*writer);
  work.loses_commit = true;
  {
    WriterHolder holder(*writer);
    for (int n = 0; n < 3; ++n) work.Insert(n, 10);
    holder.Release();
  }
  for (const auto& result : work.Results()) CHECK(absl::IsUnavailable(result.status()));
  CHECK(work.Count() == 3);
  CHECK(work.transactions() == std::vector<std::int64_t>{30});
}

}  // namespace
}  // namespace motiondb::tests::shared_transaction_test
