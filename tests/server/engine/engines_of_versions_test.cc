// Engines of several versions, and with different clocks, on one store.
#include <span>

#include "tests/server/engine/several_engines.h"

namespace motiondb::tests::engines_of_versions_test {
namespace {

// Returns the fencing number of a lease that no server has.
std::int64_t AcquireLease(storage::MotionStore& store) {
  absl::StatusOr<std::int64_t> fence;
  Await([&] {
    fence = store.AcquireBuildLease("d", "another", std::chrono::hours(1));
    return fence.ok();
  });
  return *fence;
}

// Changes a stored clip as a server of another version, or with another clock, would.
template <typename Change>
void ChangeClip(storage::MotionStore& store, const std::string& id, const Change& change) {
  const std::int64_t fence = AcquireLease(store);
  storage::DerivedClip derived{.record = Require(store.GetClip("d", id)), .states = std::nullopt};
  change(derived.record);
  REQUIRE(Require(store.PutDerived("d", std::span(&derived, 1), fence)).size() == 1);
  REQUIRE_OK(store.ReleaseBuildLease("d", fence));
}

// Waits until a build after the first `before` ones was postponed, and two looks later.
void AwaitPostponedBuild(OneServer& server, int before) {
  Await([&] { return server.postponed_build_count > before; });
  const int looks = server.look_count;
  Await([&] {
    server.engine->LookNow();
    return server.look_count >= looks + 2;
  });
}

}  // namespace

TEST_CASE("Engines on one store: a server does not build clips of a newer version",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer old(store);
  const std::string clip = BuildOneClip(old, *store);
  const int version = VersionOf(old);
  const auto set_version = [&](int representation) {
    ChangeClip(*store, clip, [&](storage::ClipRecord& record) {
      record.representation_version = record.tried_version = representation;
    });
  };
  set_version(core::kRepresentationVersion + 1);
  const int postponed = old.postponed_build_count;
  const auto operation = Ingest(old, "walk", 0.2);
  const auto reprocess = Require(old.engine->ReprocessDatabase("d"));
  AwaitPostponedBuild(old, postponed);
  CHECK_FALSE(store->GetOperation(operation.id)->done());
  CHECK_FALSE(store->GetOperation(reprocess.id)->done());
  CHECK(VersionOf(old) == version);
  CHECK(store->GetClip("d", clip)->representation_version == core::kRepresentationVersion + 1);
  set_version(core::kRepresentationVersion);
  Await([&] { return Serves(old, 2); });
  Await([&] { return store->GetOperation(operation.id)->state == OperationState::kSucceeded; });
}

TEST_CASE("Engines on one store: an older server does not replace a model of a newer version",
          "[server][servers]") {
  auto options = TestEngine::QuickOptions();
  options.extend_from = std::chrono::duration<double>(GENERATE(0, 3600));
  options.rebuild_retry_delay = std::chrono::milliseconds(500);
  const auto store = NewStore();
  OneServer old(store, options);
  BuildOneClip(old, *store);
  old.is_old = true;
  const int version = VersionOf(old);
  {
    OneServer newer(store, options);
    Ingest(newer, "walk", 0.2);
    Await([&] { return Serves(newer, 2); });
    const auto operation = Ingest(old, "walk", 0.3);
    Await([&] { return Serves(newer, 3); });
    Await([&] { return store->GetOperation(operation.id)->state == OperationState::kSucceeded; });
    CHECK(Require(store->ListModels("d", 0, 1))[0].version == VersionOf(newer));
    CHECK(VersionOf(old) == version);
  }
  const int newest = Require(store->ListModels("d", 0, 1))[0].version;
  const int postponed = old.postponed_build_count;
  const auto operation = Ingest(old, "walk", 0.4);
  AwaitPostponedBuild(old, postponed);
  CHECK_FALSE(store->GetOperation(operation.id)->done());
  CHECK(Require(store->ListModels("d", 0, 1))[0].version == newest);
  CHECK(VersionOf(old) == version);
  old.is_old = false;
  Await([&] { return Serves(old, 4); });
}

TEST_CASE("Engines on one store: a clip of a server whose clock is ahead is derived again",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  const std::string clip = BuildOneClip(a, *store);
  std::int64_t tried_us = 0;
  ChangeClip(*store, clip,
             [&](storage::ClipRecord& record) { tried_us = record.tried_time_us += 8'000'000; });
  const auto operation = Require(a.engine->ReprocessDatabase("d"));
  Await([&] { return store->GetOperation(operation.id)->done(); });
  CHECK(store->GetClip("d", clip)->tried_time_us < tried_us);
}

}  // namespace motiondb::tests::engines_of_versions_test
