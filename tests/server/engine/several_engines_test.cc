// What one engine changes, builds and ends, the others follow.
#include "tests/server/engine/several_engines.h"

namespace motiondb::tests::several_engines_test {

TEST_CASE("Engines on one store: each serves what the others change", "[server][servers]") {
  auto options = TestEngine::QuickOptions();
  options.extend_from = std::chrono::duration<double>(GENERATE(0, 3600));
  const auto store = NewStore();
  OneServer a(store, options);
  OneServer b(store, options);
  Create(a, "d");
  Await([&] { return b.engine->FindDatabase("d").ok(); });
  const auto first = Ingest(b, "walk", 0.1);
  Await([&] { return Serves(a, 1) && Serves(b, 1); });
  Await([&] { return StateOf(a, first.id) == OperationState::kSucceeded; });
  Ingest(a, "walk", 0.2);
  Ingest(b, "walk", 0.3);
  Await([&] { return Serves(a, 3) && Serves(b, 3); });
  Await([&] { return store->ListUnfinishedOperations()->empty(); });
  Await([&] { return VersionOf(a) == VersionOf(b); });
  CHECK(Require(b.engine->FindDatabase("d"))->stored().clip_count == 3);

  storage::ClipChange label;
  label.clip = "walk";
  label.label = "stroll";
  const auto edited = Require(a.engine->Edit("d", std::vector<storage::Change>{label}, "somebody"));
  Await([&] {
    b.engine->LookNow();
    const auto live = Require(b.engine->FindDatabase("d"));
    return live->lifecycle().served().revision >= edited.revision;
  });
  CHECK(Require(b.engine->FindDatabase("d"))->seen_revision() == edited.revision);
  CHECK(b.engine->SecondsSinceLook() > 0);
  CHECK(b.engine->SecondsSinceLook() < 10);

  REQUIRE_OK(b.engine->DeleteDatabase("d"));
  Await([&] {
    a.engine->LookNow();
    return !a.engine->FindDatabase("d").ok();
  });
  Create(b, "d");
  Await([&] {
    a.engine->LookNow();
    return a.engine->FindDatabase("d").ok();
  });
  CHECK(Require(a.engine->FindDatabase("d"))->lifecycle().snapshot() == nullptr);
}

TEST_CASE("Engines on one store: an acknowledged clip is counted once", "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  Create(a, "d");
  const auto live = Require(a.engine->FindDatabase("d"));
  // As an update of the model does it at any time.
  std::vector<int> seen;
  a.around_add = [&] {
    REQUIRE_OK(live->Recount(a.engine->store().annotations()));
    seen.push_back(live->stored().clip_count);
  };
  for (int count = 1; count <= 3; ++count) {
    Ingest(a, fmt::format("walk{}", count), 0.1 * count);
    CHECK(live->stored().clip_count == count);
    CHECK(seen == std::vector{count - 1, count});
    seen.clear();
  }
  REQUIRE_OK(a.engine->DeleteClip("d", "walk2"));
  CHECK(live->stored().clip_count == 2);
}

TEST_CASE("Engines on one store: a builder that stops is replaced and publishes nothing",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  Create(a, "d");
  a.model_gate->Close();
  const auto operation = Ingest(a, "walk", 0.1);
  a.model_gate->AwaitArrival();
  a.is_stopped = true;
  OneServer b(store);
  const auto began = std::chrono::steady_clock::now();
  Await([&] { return Serves(b, 1); });
  CHECK(std::chrono::steady_clock::now() - began < seconds(10));
  Await([&] { return StateOf(b, operation.id) == OperationState::kSucceeded; });
  const auto models = store->ListModels("d", 0, 10)->size();
  CHECK(LeasesOf(a).acquired == 1);
  CHECK(LeasesOf(b).acquired >= 1);
  CHECK(LeasesOf(b).refused >= 1);
  Ingest(b, "walk", 0.2);
  Await([&] { return Serves(b, 2); });
  a.is_stopped = false;
  a.model_gate->Open();
  Await([&] { return Serves(a, 2); });
  CHECK(VersionOf(a) == VersionOf(b));
  CHECK(LeasesOf(a).lost == 1);
  CHECK_FALSE(LeasesOf(a).is_held);
  CHECK(LeasesOf(b).lost == 0);
  CHECK(store->ListModels("d", 0, 10)->size() == models + 1);
  CHECK(StateOf(a, operation.id) == OperationState::kSucceeded);
}

TEST_CASE("Engines on one store: a builder that stops while it derives clips stores none",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  const std::string clip = BuildOneClip(a, *store);
  a.derive_gate->Close();
  const auto operation = Require(a.engine->ReprocessDatabase("d"));
  a.derive_gate->AwaitArrival();
  a.is_stopped = true;
  OneServer b(store);
  Await([&] { return store->GetOperation(operation.id)->done(); });
  const auto derived = Require(store->GetClip("d", clip));
  a.is_stopped = false;
  a.derive_gate->Open();
  Await([&] { return LeasesOf(a).lost == 1; });
  Await([&] { return StateOf(a, operation.id) == OperationState::kSucceeded; });
  CHECK(Require(store->GetClip("d", clip)).revision == derived.revision);
  CHECK(store->GetOperation(operation.id)->state == OperationState::kSucceeded);
}

TEST_CASE("Engines on one store: looks soon after each notification, once after many",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  Await([&] { return a.look_count > 0; });
  constexpr int kRounds = 10;
  const auto began = std::chrono::steady_clock::now();
  for (int round = 0; round < kRounds; ++round) {
    const int before = a.look_count;
    for (int i = 0; i < 100; ++i) a.on_change({});
    Await([&] { return a.look_count > before; });
  }
  // Without notifications: a look in each second.
  CHECK(std::chrono::steady_clock::now() - began < seconds(kRounds) / 2);
  CHECK(a.look_count < 5 * kRounds);
}

TEST_CASE("Engines on one store: a model is replaced while a server that starts reads it",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  Create(a, "d");
  Ingest(a, "walk", 0.1);
  Await([&] { return Serves(a, 1); });
  OneServer b(store, TestEngine::QuickOptions(), [&] {
    Ingest(a, "walk", 0.2);
    Await([&] { return Serves(a, 2); });
  });
  const auto served = Require(b.engine->FindDatabase("d"))->lifecycle().snapshot();
  REQUIRE(served != nullptr);
  CHECK(static_cast<std::size_t>(served->record.clip_count) == served->model.clips().size());
}

TEST_CASE("Engines on one store: a change of a deleted database is not made in one of its name",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  OneServer b(store);
  const std::string clip = BuildOneClip(a, *store);
  Await([&] { return Serves(b, 1); });
  Create(b, "other");  // SQLite uses the last key again
  // From now on, `b` does not see what `a` changes.
  b.is_stopped = true;
  Await([&] { return b.engine->SecondsSinceLook() > 1.1; });
  REQUIRE_OK(a.engine->DeleteDatabase("d"));
  Create(a, "d");

  const auto is_refused = [](const auto& changed) {
    return motiondb::tests::StatusOf(changed).code() == absl::StatusCode::kAborted;
  };
  const auto stale = Require(b.engine->FindDatabase("d"));
  CHECK(is_refused(TryIngest(b, "walk", 0.2)));
  CHECK(is_refused(b.engine->ReprocessDatabase("d")));
  CHECK(Require(store->ListClips("d", {})).empty());
  CHECK(Require(store->ListOperations("d", "", 10)).empty());
  Ingest(a, "walk", 0.1);
  Await([&] { return Serves(a, 1); });
  CHECK(is_refused(TryIngest(b, "walk", 0.2)));
  CHECK(is_refused(b.engine->DeleteClip("d", clip)));
  storage::ClipChange label{.clip = clip};
  label.label = "stroll";
  CHECK(is_refused(b.engine->Edit("d", std::vector<storage::Change>{label}, "somebody")));
  CHECK(Require(store->ListClips("d", {})).size() == 1);
  CHECK(Require(store->GetClip("d", clip)).label != "stroll");
  CHECK(is_refused(b.engine->DeleteDatabase("d")));
  CHECK(Require(store->GetDatabase("d")).id != stale->id());

  b.is_stopped = false;
  Await([&] {
    b.engine->LookNow();
    const auto live = b.engine->FindDatabase("d");
    return live.ok() && *live != stale && Serves(b, 1);
  });
  REQUIRE_OK(TryIngest(b, "walk", 0.2));
  Await([&] { return Serves(a, 2) && Serves(b, 2); });
}

TEST_CASE("Engines on one store: a build is cancelled on any server", "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  OneServer b(store);
  Create(a, "d");
  a.model_gate->Close();
  const auto operation = Ingest(a, "walk", 0.1);
  a.model_gate->AwaitArrival();
  const auto cancellation = Require(b.engine->CancelOperation(operation.id));
  CHECK(cancellation.is_first);
  CHECK(cancellation.operation.state == OperationState::kCancelled);
  CHECK_FALSE(Require(b.engine->CancelOperation(operation.id)).is_first);
  a.model_gate->Open();
  Await([&] { return StateOf(a, operation.id) == OperationState::kCancelled; });
  CHECK(store->GetOperation(operation.id)->state == OperationState::kCancelled);
}

TEST_CASE("Engines on one store: space is freed after an outage", "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  Create(a, "d");
  Await([&] { return a.purge_count == 1; });  // at the start
  a.is_stopped = true;
  Await([&] {
    a.engine->LookNow();
    return a.failed_look_count > 0;
  });
  REQUIRE_OK(a.engine->DeleteDatabase("d"));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  CHECK(a.purge_count == 1);
  a.is_stopped = false;
  Await([&] { return a.purge_count == 2; });
}

TEST_CASE("Engines on one store: only servers that build do so", "[server][servers]") {
  const auto store = NewStore();
  auto options = TestEngine::QuickOptions();
  options.work = server::ServerWork::kServe;
  OneServer serves(store, options);
  Create(serves, "d");
  const auto operation = Ingest(serves, "walk", 0.1);
  std::this_thread::sleep_for(seconds(1));
  CHECK(StateOf(serves, operation.id) == OperationState::kPending);
  OneServer builds(store);
  Await([&] { return Serves(serves, 1); });
  Await([&] { return StateOf(serves, operation.id) == OperationState::kSucceeded; });
}

}  // namespace motiondb::tests::several_engines_test
