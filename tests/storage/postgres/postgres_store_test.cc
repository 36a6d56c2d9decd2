// The PostgreSQL store: the conformance suite on a real cluster.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <set>
#include <thread>

#include "core/motion/error.h"
#include "storage/postgres/postgres_connection.h"
#include "storage/postgres/postgres_motion_store.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/clip_table.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/operation_table.h"
#include "tests/storage/conformance/motion_store_conformance.h"
#include "tests/storage/postgres/postgres_cluster.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"

namespace motiondb::tests::postgres_store_test {
namespace {

using absl::StatusCode;

storage::PostgresOptions AtPutTime() {
  storage::PostgresOptions options;
  options.now_us = [] { return kPutTime; };
  return options;
}

class OnPostgres final : public StoreUnderTest {
 public:
  // `url`: of the database; through pgbouncer, each transaction gets another session.
  OnPostgres(PostgresCluster& cluster, std::string (*url)(const PostgresDatabase&))
      : database_(cluster),
        store_(Require(storage::PostgresMotionStore::Open(url(database_), AtPutTime()))) {}
  storage::MotionStore& Get() override { return *store_; }

 private:
  PostgresDatabase database_;
  std::unique_ptr<storage::PostgresMotionStore> store_;
};

// Uses two stores, as two servers do, in turn.
class OnTwoServers final : public StoreUnderTest {
 public:
  explicit OnTwoServers(PostgresCluster& cluster) : database_(cluster) {
    for (auto& store : stores_) {
      store = Require(storage::PostgresMotionStore::Open(database_.Url(), AtPutTime()));
    }
  }
  storage::MotionStore& Get() override { return *stores_[++calls_ % 2]; }

 private:
  PostgresDatabase database_;
  std::array<std::unique_ptr<storage::PostgresMotionStore>, 2> stores_;
  std::size_t calls_ = 0;
};

}  // namespace

TEST_CASE("PostgresMotionStore: conforms", "[storage][postgres][conformance]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const auto url = [](const PostgresDatabase& database) { return database.Url(); };
  TestMotionStore([&] { return std::make_unique<OnPostgres>(*cluster, url); });
}

TEST_CASE("PostgresMotionStore: conforms without prepared statements",
          "[storage][postgres][conformance]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const auto url = [](const PostgresDatabase& database) { return database.Url("&pooled=1"); };
  TestMotionStore([&] { return std::make_unique<OnPostgres>(*cluster, url); });
}

TEST_CASE("PostgresMotionStore: conforms through pgbouncer in transaction mode",
          "[storage][postgres][conformance][pooler]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr || cluster->PooledUrl("postgres").empty()) return;
  const auto url = [](const PostgresDatabase& database) { return database.PooledUrl(); };
  TestMotionStore([&] { return std::make_unique<OnPostgres>(*cluster, url); });
}

TEST_CASE("PostgresMotionStore: conforms if two servers take turns",
          "[storage][postgres][conformance]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  TestMotionStore([&] { return std::make_unique<OnTwoServers>(*cluster); });
}

TEST_CASE("PostgresMotionStore: servers that open an empty database together make one store",
          "[storage][postgres][concurrency]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  std::array<absl::Status, 4> opened;
  {
    std::vector<std::jthread> threads;
    for (absl::Status& status : opened) {
      threads.emplace_back(
          [&] { status = storage::PostgresMotionStore::Open(database.Url()).status(); });
    }
  }
  for (const absl::Status& status : opened) REQUIRE_OK(status);
  REQUIRE(database.Sql("SELECT count(*) || ' ' || min(version) FROM motiondb_schema") == "1 4");
}

TEST_CASE("PostgresMotionStore: refuses a newer store and a database that it cannot use",
          "[storage][postgres]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  REQUIRE_ERROR(storage::PostgresMotionStore::Open(database.Url(), {.read_only = true}),
                StatusCode::kFailedPrecondition, "version 0");
  database.Sql("CREATE TABLE clip (other integer)");
  REQUIRE_ERROR(storage::PostgresMotionStore::Open(database.Url()), StatusCode::kFailedPrecondition,
                "already exists");
  REQUIRE(database.Sql("SELECT count(*) FROM pg_class WHERE relname = 'motiondb_schema'") == "0");
  database.Sql("DROP TABLE clip");
  REQUIRE_OK(storage::PostgresMotionStore::Open(database.Url()));
  REQUIRE_OK(storage::PostgresMotionStore::Open(database.Url(), {.read_only = true}));
  database.Sql("UPDATE motiondb_schema SET version = 99");
  for (const bool read_only : {false, true}) {
    REQUIRE_ERROR(storage::PostgresMotionStore::Open(database.Url(), {.read_only = read_only}),
                  StatusCode::kFailedPrecondition, "version 99, from a newer motiondb");
  }
}

TEST_CASE("PostgresMotionStore: upgrades an older store while an old server runs",
          "[storage][postgres]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const int old_version = GENERATE(1, 2, 3);
  const PostgresDatabase database(*cluster);
  auto connector = std::make_shared<storage::PostgresConnector>(
      Require(storage::ParsePostgresUrl(database.Url())));
  const auto old_server = Require(storage::PostgresConnection::Open(connector));
  REQUIRE(Require(storage::MigratePostgres(*old_server, old_version)).now == old_version);
  const auto write = [&](const auto& work) {
    return storage::InTransaction(*old_server, storage::Transaction::Kind::kWrite, work);
  };
  const auto add = [&](const char* name) {
    return write([&](storage::Connection& connection) -> absl::Status {
      MOTIONDB_RETURN_IF_ERROR(storage::InsertDatabase(connection, SampleDatabase(name)));
      return storage::InsertClip(connection, SampleClip(name, "walk", 1)).status();
    });
  };
  REQUIRE_OK(add("before"));
  const auto store = Require(storage::PostgresMotionStore::Open(database.Url()));
  REQUIRE(store->versions().before == old_version);
  REQUIRE(store->versions().now == 4);
  REQUIRE_OK(add("after"));
  REQUIRE_OK(write([&](storage::Connection& connection) {
    return storage::UpsertOperation(connection, SampleOperation("after", "of-the-old-server"));
  }));
  REQUIRE_OK(write([&](storage::Connection& connection) {
    return storage::RemoveClip(connection, "before", "walk", storage::FreePolicy::kFree).status();
  }));
  REQUIRE(Require(store->ListDatabases({})).size() == 2);
  REQUIRE_OK(store->GetOperation("of-the-old-server"));
  REQUIRE(Same(Require(store->ReadClipStates("after", "walk")), SampleClip("d", "walk", 1).states));
  REQUIRE(Require(store->ListClips("before", {})).empty());
  if (old_version >= 2) {
    // The lease of either is one for both.
    REQUIRE_OK(write([&](storage::Connection& connection) -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(const auto key, storage::FindDatabase(connection, "after"));
      return storage::AcquireLease(connection, key, "old server", 1, INT64_MAX).status();
    }));
    REQUIRE_ERROR(store->AcquireBuildLease("after", "new server", std::chrono::seconds(1)),
                  StatusCode::kAborted, "'old server'");
  }
  REQUIRE(Findings(*store) == "");
  // It cannot start again.
  REQUIRE_ERROR(storage::MigratePostgres(*old_server, old_version), StatusCode::kFailedPrecondition,
                "version 4, from a newer motiondb; this one supports versions up to " +
                    std::to_string(old_version));
}

TEST_CASE("PostgresMotionStore: read-only refuses changes", "[storage][postgres]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  REQUIRE_OK(Require(storage::PostgresMotionStore::Open(database.Url()))
                 ->CreateDatabase(SampleDatabase("d")));
  const auto store =
      Require(storage::PostgresMotionStore::Open(database.Url(), {.read_only = true}));
  REQUIRE_OK(store->GetDatabase("d"));
  REQUIRE_ERROR(store->CreateDatabase(SampleDatabase("e")), StatusCode::kFailedPrecondition,
                "read-only");
  REQUIRE_ERROR(store->CheckIsWritable(), StatusCode::kFailedPrecondition, "read-only");
}

TEST_CASE("PostgresMotionStore: a reader of changes misses none of several servers",
          "[storage][postgres][concurrency]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  constexpr int kServers = 3;
  constexpr int kClips = 12;
  const PostgresDatabase database(*cluster);
  const auto reader = Require(storage::PostgresMotionStore::Open(database.Url()));
  REQUIRE_OK(reader->CreateDatabase(SampleDatabase("d")));
  std::array<absl::Status, kServers> added;
  std::vector<std::jthread> servers;
  for (int s = 0; s < kServers; ++s) {
    servers.emplace_back([&, s] {
      const auto store = storage::PostgresMotionStore::Open(database.Url());
      added[static_cast<std::size_t>(s)] = store.status();
      for (int c = 0; store.ok() && c < kClips; ++c) {
        const auto seed = static_cast<unsigned>(100 * s + c);
        // The same ids on all servers: each gets a number of its own.
        added[static_cast<std::size_t>(s)].Update(
            (*store)->AddClip(SampleClip("d", "walk" + std::to_string(c), seed)).status());
      }
    });
  }
  std::set<std::string> seen;
  std::int64_t revision = 0;
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  while (seen.size() < kServers * kClips && std::chrono::steady_clock::now() < latest) {
    for (const auto& record : Require(reader->Changes("d", revision, 3))) {
      REQUIRE(record.revision >= revision);
      revision = record.revision;
      if (const auto* const put = std::get_if<storage::ClipPut>(&record.change)) {
        REQUIRE(seen.insert(put->clip.id).second);
      }
    }
  }
  servers.clear();
  for (const absl::Status& status : added) REQUIRE_OK(status);
  REQUIRE(seen.size() == kServers * kClips);
  REQUIRE(seen.contains("walk0-3"));
  REQUIRE(revision == kServers * kClips);
}

TEST_CASE("PostgresMotionStore: recovers after PostgreSQL was gone", "[storage][postgres]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto store = Require(storage::PostgresMotionStore::Open(database.Url()));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
  REQUIRE_OK(store->CheckWrites());
  cluster->Kill();
  REQUIRE_ERROR(store->AddClip(SampleClip("d", "run", 2)), StatusCode::kUnavailable, "PostgreSQL");
  REQUIRE(store->GetDatabase("d").status().code() == StatusCode::kUnavailable);
  REQUIRE(store->CheckWrites().code() == StatusCode::kUnavailable);
  REQUIRE(store->write_failures().io_error >= 1);
  const auto broken = store->connections();
  REQUIRE(broken.opened_sessions >= 1);
  REQUIRE(broken.failed_sessions >= 1);
  cluster->Start();
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!store->CheckWrites().ok()) {
    REQUIRE(std::chrono::steady_clock::now() < latest);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  REQUIRE_OK(store->AddClip(SampleClip("d", "run", 2)));
  REQUIRE(Require(store->ListClips("d", {})).size() == 2);
  REQUIRE(store->connections().opened_sessions >= broken.opened_sessions + 2);
}

TEST_CASE("PostgresMotionStore: corruption is DATA_LOSS, and a verification names it",
          "[storage][postgres][verify]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto store = Require(storage::PostgresMotionStore::Open(database.Url()));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
  REQUIRE_OK(store->PutModel("d", SampleModel({SampleClip("d", "walk", 1)})));
  REQUIRE_OK(store->PutOperation(SampleOperation("d", "op")));
  storage::ClipChange title;
  title.clip = "walk";
  title.title = "A title";
  REQUIRE_OK(store->Edit("d", std::vector<storage::Change>{title}, "p"));
  REQUIRE_OK(store->AddToken({.id = "t", .salt = "s", .secret_hash = "h"}));
  REQUIRE(Findings(*store) == "");  // shows what was found
  // Without triggers, as a disk changes bytes.
  const auto change = [&](const std::string& sql) {
    database.Sql("SET session_replication_role = replica; " + sql);
  };
  const auto [sql, found] = GENERATE(table<std::string, std::string>({
      {"UPDATE clip SET title = 'x'", "databases/d/clips/walk: row 1 of table clip"},
      {"UPDATE database SET min_frames = 7", "databases/d: row 1 of table database"},
      {"UPDATE model SET build_seconds = 9", "databases/d/models/1: row 1 of table model"},
      {"UPDATE model_layer SET node_count = 99", ": row 1 of table model_layer"},
      {"UPDATE edit SET author = 'x'", "databases/d/edits/3: row 1 of table edit"},
      {"UPDATE operation SET stage = 'x'", "operations/op: row 1 of table operation"},
      {"UPDATE token SET role = 'admin'", "tokens/t: row 1 of table token"},
      {"UPDATE clip_text SET subject = 'x'", "databases/d/clips/walk: search index"},
      {"DELETE FROM clip_chunk WHERE kind = 2",
       "databases/d/clips/walk: skeleton file: chunk 0 is missing"},
      {"UPDATE clip_chunk SET chunk = set_byte(chunk, 40, 255 - get_byte(chunk, 40)) WHERE kind = "
       "3",
       "databases/d/clips/walk: states: chunk 0 is corrupt"},
      {"UPDATE model_chunk SET chunk = set_byte(chunk, 40, 255 - get_byte(chunk, 40))",
       "databases/d/models/1: parts: chunk 0 is corrupt"},
  }));
  change(sql);
  REQUIRE_THAT(Findings(*store), Catch::Contains(found));
  if (sql.find("kind = 3") != std::string::npos) {
    REQUIRE_ERROR(store->ReadClipStates("d", "walk"), StatusCode::kDataLoss, "states: chunk 0");
  }
  if (sql.find("model_chunk") != std::string::npos) {
    REQUIRE_ERROR(store->ReadModel("d", core::RunSerially), StatusCode::kDataLoss,
                  "parts: chunk 0");
  }
}

TEST_CASE("PostgresMotionStore: long words are found, also among equal beginnings",
          "[storage][postgres]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto store = Require(storage::PostgresMotionStore::Open(database.Url()));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  const std::string beginning(300, 'x');
  auto a = SampleClip("d", "a", 1);
  a.record.title = beginning + "a";
  auto b = SampleClip("d", "b", 2);
  b.record.title = beginning + "b " + std::string(5000, 'y');
  REQUIRE_OK(store->AddClip(a));
  REQUIRE_OK(store->AddClip(b));
  const auto found = [&](const std::string& query) {
    std::string ids;
    for (const auto& match : Require(store->SearchClips("d", query))) ids += match.clip;
    std::ranges::sort(ids);
    return ids;
  };
  CHECK(found(beginning + "a") == "a");
  CHECK(found(beginning + "*") == "ab");
  CHECK(found(beginning).empty());
  CHECK(found(std::string(5000, 'y')) == "b");
}

}  // namespace motiondb::tests::postgres_store_test
