// Servers that share a PostgreSQL store wake each other.
#include "storage/postgres/postgres_watch.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "storage/mutex.h"
#include "storage/postgres/postgres_motion_store.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/storage/postgres/postgres_cluster.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests::postgres_watch_test {
namespace {

using storage::PostgresMotionStore;
using storage::StoreChange;

// The changes that a watch has notified.
class Notified {
 public:
  storage::OnStoreChange Note() {
    return [this](const StoreChange& change) {
      const storage::MutexLock lock(mutex_);
      changes_.push_back(change);
    };
  }
  // Returns the newest revision of a database; with an empty name, the number of other changes.
  std::int64_t Of(const std::string& database) {
    const storage::MutexLock lock(mutex_);
    std::int64_t number = 0;
    for (const StoreChange& change : changes_) {
      if (change.database == database) number = database.empty() ? number + 1 : change.revision;
    }
    return number;
  }
  // Waits until Of(database) is `number` or more.
  bool Reaches(const std::string& database, std::int64_t number) {
    const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (Of(database) < number) {
      if (std::chrono::steady_clock::now() > latest) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }

 private:
  storage::Mutex mutex_;
  std::vector<StoreChange> changes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

TEST_CASE("PostgresWatch: each change of another server is notified after its commit",
          "[storage][postgres][watch]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto writer = Require(PostgresMotionStore::Open(database.Url()));
  const auto reader = Require(PostgresMotionStore::Open(database.Url(), {.read_only = true}));
  Notified notified;
  const auto watch = reader->WatchChanges(notified.Note());
  REQUIRE(watch != nullptr);
  REQUIRE(notified.Reaches("", 1));  // it listens

  REQUIRE_OK(writer->CreateDatabase(SampleDatabase("d \xc3\xa4 \xff")));
  REQUIRE(notified.Reaches("", 2));
  const auto name = SampleDatabase("d \xc3\xa4 \xff").name;
  REQUIRE_OK(writer->AddClip(SampleClip(name, "walk", 1)));
  REQUIRE(notified.Reaches(name, Require(writer->Revision(name))));
  // Read within the call, a change is there: the notification follows the commit.
  REQUIRE(Require(reader->Revision(name)) == notified.Of(name));
  storage::ClipChange title;
  title.clip = "walk";
  title.title = "A title";
  REQUIRE_OK(writer->Edit(name, std::vector<storage::Change>{title}, "p"));
  REQUIRE(notified.Reaches(name, Require(writer->Revision(name))));
  REQUIRE_OK(writer->PutModel(name, SampleModel({SampleClip(name, "walk", 1)})));
  REQUIRE(notified.Reaches(name, Require(writer->Revision(name))));
  REQUIRE_OK(writer->DeleteClip(name, "walk"));
  REQUIRE(notified.Reaches(name, Require(writer->Revision(name))));

  std::int64_t others = notified.Of("");
  const auto wakes = [&] { return notified.Reaches("", ++others); };
  REQUIRE_OK(writer->AddToken({.id = "t", .salt = "s", .secret_hash = "h"}));
  REQUIRE(wakes());
  REQUIRE_OK(writer->RevokeToken("t", 1));
  REQUIRE(wakes());
  REQUIRE_OK(writer->PutOperation(SampleOperation(name, "op")));
  REQUIRE(wakes());
  REQUIRE_OK(writer->DeleteDatabase(name));
  REQUIRE(wakes());
}

TEST_CASE("PostgresWatch: a change that is rolled back is not notified",
          "[storage][postgres][watch]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto store = Require(PostgresMotionStore::Open(database.Url()));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  Notified notified;
  const auto watch = store->WatchChanges(notified.Note());
  REQUIRE(notified.Reaches("", 1));
  database.Sql("BEGIN; UPDATE database SET revision = 1000; ROLLBACK");
  database.Sql("UPDATE database SET revision = 7");
  REQUIRE(notified.Reaches("d", 7));
  REQUIRE(notified.Of("d") == 7);
}

TEST_CASE("PostgresWatch: listens again after PostgreSQL was gone", "[storage][postgres][watch]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto store = Require(PostgresMotionStore::Open(database.Url()));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  Notified notified;
  const auto watch = store->WatchChanges(notified.Note());
  REQUIRE(notified.Reaches("", 1));
  cluster->Kill();
  Notified later;  // begins while PostgreSQL is gone
  auto early = store->WatchChanges(later.Note());
  const auto begun = std::chrono::steady_clock::now();
  {
    const auto ended = store->WatchChanges([](const StoreChange&) {});
  }
  REQUIRE(std::chrono::steady_clock::now() - begun < std::chrono::seconds(4));
  cluster->Start();
  REQUIRE(notified.Reaches("", 2));  // something may have changed
  REQUIRE(later.Reaches("", 1));
  early.reset();
  database.Sql("UPDATE database SET revision = 7");
  REQUIRE(notified.Reaches("d", 7));
  REQUIRE(later.Of("d") == 0);
}

TEST_CASE("PostgresWatch: a pooler and a file cannot notify", "[storage][postgres][watch]") {
  const auto file = Require(storage::SqliteMotionStore::Open(":memory:"));
  REQUIRE(file->WatchChanges([](const StoreChange&) {}) == nullptr);
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto store = Require(PostgresMotionStore::Open(database.Url("&pooled=1")));
  REQUIRE(store->WatchChanges([](const StoreChange&) {}) == nullptr);
}

}  // namespace motiondb::tests::postgres_watch_test
