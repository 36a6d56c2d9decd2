// The databases of a backup are served after they are read, not before.
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "server/engine/snapshot.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::restore_test {
namespace {

// Creates database "db" with the clip "a" and its model.
void Fill(TestEngine& engine) {
  engine.Create("db");
  engine.Wait(engine.Ingest("db", "a", Walk(0))->operation.id);
}

// Transfers a complete backup of `from` to `to`.
std::unique_ptr<storage::StoreRestore> Bring(TestEngine& from, TestEngine& to) {
  auto backup = from->store().maintenance().BeginBackup({});
  REQUIRE(backup.ok());
  auto restore = to->store().maintenance().BeginRestore();
  REQUIRE(restore.ok());
  std::string block;
  while (*(*backup)->Read(block)) REQUIRE((*restore)->Append(block).ok());
  return *std::move(restore);
}

// A restore that calls `meanwhile` before its check.
class InterruptedRestore final : public storage::StoreRestore {
 public:
  InterruptedRestore(std::unique_ptr<storage::StoreRestore> restore,
                     std::function<void()> meanwhile)
      : restore_(std::move(restore)), meanwhile_(std::move(meanwhile)) {}
  absl::Status Append(std::string_view bytes) override { return restore_->Append(bytes); }
  absl::Status Check(const core::Cancelled& cancelled) override {
    meanwhile_();
    return restore_->Check(cancelled);
  }
  absl::Status Finish(const core::Cancelled& cancelled) override {
    return restore_->Finish(cancelled);
  }

 private:
  const std::unique_ptr<storage::StoreRestore> restore_;
  const std::function<void()> meanwhile_;
};

}  // namespace

TEST_CASE("Restore: a restored database is served immediately", "[server][restore]") {
  TestEngine from;
  Fill(from);
  TestEngine to;
  const auto restore = Bring(from, to);
  to.gate().Close();  // a build would stop here
  const auto restored = to->Restore(*restore, {});
  INFO(restored.status().ToString());
  REQUIRE(restored.ok());
  CHECK(restored->database_count == 1);
  CHECK(restored->clip_count == 1);
  const auto snapshot = (*to->FindDatabase("db"))->lifecycle().snapshot();
  REQUIRE(snapshot != nullptr);
  CHECK(snapshot->model.states() ==
        (*from->FindDatabase("db"))->lifecycle().snapshot()->model.states());
  CHECK(snapshot->record.version == 1);
  to.gate().Open();
  to.Wait(to.Ingest("db", "b", Walk(1))->operation.id);
  CHECK((*to->FindDatabase("db"))->lifecycle().snapshot()->model.clips().size() == 2);
}

TEST_CASE("Restore: a database is visible only after its clips are counted and its model read",
          "[server][restore]") {
  TestEngine from;
  Fill(from);
  TestEngine to;
  const auto restore = Bring(from, to);
  to.reading_gate().Close();
  absl::StatusOr<server::StoreCounts> restored;
  std::jthread restoring([&] { restored = to->Restore(*restore, {}); });
  to.reading_gate().AwaitArrival();
  CHECK(absl::IsNotFound(to->FindDatabase("db").status()));
  CHECK(to->Databases().empty());
  to.reading_gate().Open();
  restoring.join();
  REQUIRE(restored.ok());
  const auto live = to->FindDatabase("db");
  REQUIRE(live.ok());
  CHECK((*live)->stored().clip_count == 1);
  CHECK(to->CurrentModel(**live).ok());
}

TEST_CASE("Restore: databases can be created while a backup is checked", "[server][restore]") {
  TestEngine from;
  Fill(from);
  TestEngine to;
  InterruptedRestore restore(Bring(from, to), [&] { to.Create("other"); });
  const auto restored = to->Restore(restore, {});
  CHECK(absl::IsFailedPrecondition(restored.status()));
  CHECK(to->Databases().size() == 1);
  CHECK(to->FindDatabase("other").ok());
}

TEST_CASE("Restore: a cancelled restore changes nothing", "[server][restore]") {
  TestEngine from;
  Fill(from);
  TestEngine to;
  bool is_gone = false;
  InterruptedRestore restore(Bring(from, to), [&] { is_gone = true; });
  const auto restored = to->Restore(restore, [&] { return is_gone; });
  CHECK(absl::IsCancelled(restored.status()));
  CHECK(to->Databases().empty());
  CHECK(to->store().ListDatabases({})->empty());
}

}  // namespace motiondb::tests::restore_test
