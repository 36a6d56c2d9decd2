// Servers and PostgreSQL that stop without closing their connections, and sessions of a standby.
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "core/motion/error.h"
#include "storage/postgres/postgres_connection.h"
#include "storage/postgres/postgres_motion_store.h"
#include "storage/postgres/postgres_watch.h"
#include "storage/sql/connection/connection.h"
#include "storage/store_url.h"
#include "storage/thread_scopes.h"
#include "tests/storage/postgres/postgres_cluster.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests::postgres_hang_test {
namespace {

using absl::StatusCode;
using std::chrono::duration;
using std::chrono::steady_clock;
using storage::PostgresMotionStore;
using storage::Transaction;

std::shared_ptr<storage::PostgresConnector> ConnectorOf(const std::string& url) {
  return std::make_shared<storage::PostgresConnector>(Require(storage::ParsePostgresUrl(url)));
}

std::unique_ptr<storage::PostgresConnection> Connect(const std::string& url) {
  return Require(storage::PostgresConnection::Open(ConnectorOf(url)));
}

absl::Status Ask(storage::Connection& connection) {
  return storage::InTransaction(connection, Transaction::Kind::kRead, [](storage::Connection& it) {
    return it.QueryInteger("SELECT 7").status();
  });
}

void RequireStoreUnreachable(const absl::Status& status) {
  INFO(status.ToString());
  REQUIRE(status.code() == StatusCode::kUnavailable);
  REQUIRE(std::string(status.GetPayload(core::kReasonUrl).value_or(absl::Cord())) ==
          storage::kStoreUnreachable);
}

// The result of a call and its time.
struct Timed {
  absl::Status status;
  double seconds = 0;
};

template <typename Call>
Timed Time(const Call& call) {
  const auto began = steady_clock::now();
  Timed timed{call()};
  timed.seconds = duration<double>(steady_clock::now() - began).count();
  return timed;
}

}  // namespace

TEST_CASE("PostgresMotionStore: a server that stops in a transaction blocks others for 10 s",
          "[storage][postgres][concurrency]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  std::vector<std::string> urls;
  const PostgresDatabase direct(*cluster);
  const PostgresDatabase pooled(*cluster);
  urls.push_back(direct.Url());
  if (std::string url = pooled.PooledUrl(); !url.empty()) urls.push_back(std::move(url));
  std::vector<Timed> added(urls.size());
  std::vector<absl::Status> stopped(urls.size());
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < urls.size(); ++i) {
      auto store = Require(PostgresMotionStore::Open(urls[i]));
      REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
      threads.emplace_back([&, i, store = std::move(store), other = Connect(urls[i])] {
        stopped[i] = storage::InTransaction(
            *other, Transaction::Kind::kWrite, [&](storage::Connection& it) -> absl::Status {
              MOTIONDB_RETURN_IF_ERROR(
                  it.QueryInteger("SELECT database_key FROM database FOR NO KEY UPDATE").status());
              // Too large for the buffer of libpq: a part of the queue is sent.
              const std::string large(1 << 20, 'x');
              MOTIONDB_RETURN_IF_ERROR(
                  it.Query("UPDATE motiondb_schema SET version = version WHERE ? = 'y'", large)
                      .RunLater());
              added[i] = Time([&] { return store->AddClip(SampleClip("d", "walk", 1)).status(); });
              return absl::OkStatus();
            });
      });
    }
  }
  for (std::size_t i = 0; i < urls.size(); ++i) {
    INFO(urls[i]);
    REQUIRE_OK(added[i].status);
    CHECK(added[i].seconds > 5);  // otherwise nothing was locked
    CHECK(added[i].seconds < 14);
    RequireStoreUnreachable(stopped[i]);
  }
}

TEST_CASE("PostgresConnection: waits for a lock at most 15 s, and keeps its session",
          "[storage][postgres]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  database.Sql("CREATE TABLE t (i bigint); INSERT INTO t VALUES (1)");
  const auto holder = Connect(database.Url());
  const auto waiter = Connect(database.Url());
  const int session = waiter->backend_pid();
  const auto change = [](storage::Connection& it) { return it.Query("UPDATE t SET i = 2").Run(); };
  REQUIRE_OK(storage::InTransaction(
      *holder, Transaction::Kind::kWrite, [&](storage::Connection& it) -> absl::Status {
        MOTIONDB_RETURN_IF_ERROR(change(it));
        RequireStoreUnreachable(storage::InTransaction(
            *waiter, Transaction::Kind::kWrite, [&](storage::Connection& other) -> absl::Status {
              MOTIONDB_RETURN_IF_ERROR(other.Execute("SET LOCAL lock_timeout = '50ms'"));
              return change(other);
            }));
        return absl::OkStatus();
      }));
  REQUIRE_OK(storage::InTransaction(*waiter, Transaction::Kind::kWrite, change));
  CHECK(waiter->backend_pid() == session);
}

TEST_CASE("PostgresConnection: PostgreSQL that hangs is noticed, and found again",
          "[storage][postgres][concurrency]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const std::string url = database.Url("&connect_timeout=2");
  const auto connector = ConnectorOf(url);
  const auto open = [&] { return Require(storage::PostgresConnection::Open(connector)); };
  const auto waits = open();
  const auto sends = open();
  const auto idle = open();
  const auto cancelled = Connect(url);
  storage::PostgresListener listener(ConnectorOf(url));

  std::array<Timed, 5> lost;
  std::promise<void> begun;
  std::promise<void> suspended;
  {
    // In a transaction, with more to send than the system buffers.
    const std::jthread sending([&] {
      storage::InTransaction(*sends, Transaction::Kind::kWrite, [&](storage::Connection& it) {
        begun.set_value();
        suspended.get_future().wait();
        lost[4] = Time([&] { return it.Query("SELECT ?", std::string(4 << 20, 'x')).Run(); });
        return lost[4].status;
      }).IgnoreError();
    });
    begun.get_future().wait();
    cluster->Suspend();
    suspended.set_value();
    const std::jthread waiting([&] { lost[0] = Time([&] { return Ask(*waits); }); });
    const std::jthread listening([&] { lost[1] = Time([&] { return listener.Connect(); }); });
    const std::jthread giving_up([&] {
      const core::Cancelled always = [] { return true; };
      const storage::ReadScope scope(always);
      lost[2] = Time([&] { return Ask(*cancelled); });
    });
  }
  // Other sessions then fail immediately, except for one that tries to connect.
  lost[3] = Time([&] { return Ask(*idle); });
  cluster->Resume();
  RequireStoreUnreachable(lost[0].status);
  CHECK(lost[0].seconds > 4);
  CHECK(lost[0].seconds < 10);
  RequireStoreUnreachable(lost[1].status);
  CHECK(lost[1].seconds < 10);
  CHECK(lost[2].status.code() == StatusCode::kCancelled);
  CHECK(lost[2].seconds < 3);
  RequireStoreUnreachable(lost[3].status);
  CHECK(lost[3].seconds < 3.5);
  RequireStoreUnreachable(lost[4].status);
  CHECK(lost[4].seconds < 10);
  for (const auto& session : {waits.get(), sends.get(), idle.get(), cancelled.get()}) {
    const auto latest = steady_clock::now() + std::chrono::seconds(10);
    while (!Ask(*session).ok()) {
      REQUIRE(steady_clock::now() < latest);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  REQUIRE_OK(listener.Connect());
}

TEST_CASE("PostgresConnection: a session of a standby is replaced", "[storage][postgres]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto connection = Connect(database.Url());
  const int former = connection->backend_pid();
  // The error of BEGIN READ WRITE on a standby, from a statement that PostgreSQL does not support.
  RequireStoreUnreachable(
      storage::InTransaction(*connection, Transaction::Kind::kWrite, [](storage::Connection& it) {
        return it.Query("SELECT count(*) FROM pg_class FOR UPDATE").Run();
      }));
  REQUIRE_OK(Ask(*connection));
  CHECK(connection->backend_pid() != former);
}

TEST_CASE("PostgresMotionStore: opens only a server that takes changes, unless read-only",
          "[storage][postgres]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  REQUIRE_OK(PostgresMotionStore::Open(database.Url()));
  database.Sql(
      "DO $$ BEGIN EXECUTE 'ALTER DATABASE ' || current_database() || "
      "' SET default_transaction_read_only = on'; END $$");
  RequireStoreUnreachable(PostgresMotionStore::Open(database.Url()).status());
  REQUIRE_OK(PostgresMotionStore::Open(database.Url(), {.read_only = true}));
  REQUIRE_OK(PostgresMotionStore::Open(database.Url("&target_session_attrs=any")));
  // Refused for good.
  REQUIRE_ERROR(PostgresMotionStore::Open(cluster->Url("no_such_database")),
                StatusCode::kFailedPrecondition, "no_such_database");
}

}  // namespace motiondb::tests::postgres_hang_test
