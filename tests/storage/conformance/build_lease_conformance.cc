#include "tests/storage/conformance/build_lease_conformance.h"

#include <array>
#include <chrono>
#include <random>
#include <string>
#include <vector>

#include "core/model/model_builder.h"
#include "tests/storage/faults/store_pages.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::NewClip;

constexpr std::chrono::hours kLong{1};
constexpr std::chrono::milliseconds kExpired{0};  // the lease has expired when the call returns

core::Model ExtendedBy(const core::Model& model, const NewClip& clip) {
  return Require(core::ExtendModel(
      model, {{clip.record.id, clip.record.label, clip.states, clip.record.subject}},
      core::RunSerially));
}

int CurrentVersion(StoreUnderTest& store) {
  const auto newest = Require(store->ListModels("d", 0, 1));
  return newest.empty() || !newest[0].current ? 0 : newest[0].version;
}

}  // namespace

void TestBuildLeases(StoreUnderTest& store) {
  REQUIRE_ERROR(store->AcquireBuildLease(kUnknown, "a", kLong), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->RenewBuildLease(kUnknown, 1, kLong), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->ReleaseBuildLease(kUnknown, 1), StatusCode::kNotFound, kUnknown);
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
  const NewClip walk = SampleClip("d", "walk", 1);
  const NewClip run = SampleClip("d", "run", 2);
  REQUIRE_OK(store->AddClip(walk));
  REQUIRE_OK(store->AddClip(run));
  const core::Model model = SampleModel({walk});

  REQUIRE(store->RenewBuildLease("d", 0, kLong).code() == StatusCode::kAborted);
  const std::int64_t first = Require(store->AcquireBuildLease("d", "a", kLong));
  REQUIRE(first > 0);
  REQUIRE_ERROR(store->AcquireBuildLease("d", "b", kLong), StatusCode::kAborted, "'a'");
  REQUIRE_OK(store->AcquireBuildLease("e", "b", kLong));  // each database has its own
  REQUIRE_OK(store->RenewBuildLease("d", first, kLong));
  REQUIRE_ERROR(store->AcquireBuildLease("d", "b", kLong), StatusCode::kAborted, "'a'");
  REQUIRE(store->RenewBuildLease("d", first + 1, kLong).code() == StatusCode::kAborted);

  SECTION("a released lease is free, and its number is not renewed") {
    REQUIRE_OK(store->ReleaseBuildLease("d", first));
    REQUIRE(store->RenewBuildLease("d", first, kLong).code() == StatusCode::kAborted);
    const std::int64_t second = Require(store->AcquireBuildLease("d", "b", kLong));
    REQUIRE(second > first);
    // Releasing an earlier lease does not release the last one.
    REQUIRE_OK(store->ReleaseBuildLease("d", first));
    REQUIRE_ERROR(store->AcquireBuildLease("d", "a", kLong), StatusCode::kAborted, "'b'");
  }
  SECTION("the holder can acquire its lease again") {
    const std::int64_t second = Require(store->AcquireBuildLease("d", "a", kLong));
    REQUIRE(second > first);
    REQUIRE(store->RenewBuildLease("d", first, kLong).code() == StatusCode::kAborted);
    REQUIRE_OK(store->RenewBuildLease("d", second, kLong));
  }
  SECTION("a lease that has expired is renewed unless it was taken over") {
    REQUIRE_OK(store->RenewBuildLease("d", first, kExpired));
    REQUIRE_OK(store->RenewBuildLease("d", first, kLong));
    REQUIRE_ERROR(store->AcquireBuildLease("d", "b", kLong), StatusCode::kAborted, "'a'");
    REQUIRE_OK(store->RenewBuildLease("d", first, kExpired));
    REQUIRE(Require(store->AcquireBuildLease("d", "b", kLong)) > first);
    REQUIRE(store->RenewBuildLease("d", first, kLong).code() == StatusCode::kAborted);
  }
  SECTION("a fenced builder stores nothing") {
    REQUIRE(Require(store->PutModel("d", model, {0, first})).version == 1);
    REQUIRE_OK(store->RenewBuildLease("d", first, kExpired));
    const std::int64_t second = Require(store->AcquireBuildLease("d", "b", kLong));
    const core::Model extended = ExtendedBy(model, run);
    std::vector<storage::DerivedClip> derived{{Require(store->GetClip("d", "walk")), run.states}};
    derived[0].record.frame_count = run.states.frame_count();
    for (const std::int64_t fence : {first, std::int64_t{0}}) {
      CHECK(store->PutModel("d", model, {1, fence}).status().code() == StatusCode::kAborted);
      CHECK(store->PutExtension("d", extended, 0, {1, fence}).status().code() ==
            StatusCode::kAborted);
      CHECK(store->DropModel("d", {1, fence}).code() == StatusCode::kAborted);
      CHECK(store->PutDerived("d", derived, fence).status().code() == StatusCode::kAborted);
    }
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), walk.states));
    REQUIRE(Require(store->PutDerived("d", derived, second)).size() == 1);
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), run.states));
    REQUIRE(CurrentVersion(store) == 1);
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), model));
    REQUIRE(Require(store->PutExtension("d", extended, 0, {1, second})).version == 2);
    REQUIRE(Require(store->PutModel("d", extended, {2, second})).version == 3);
    REQUIRE_OK(store->DropModel("d", {3, second}));
    REQUIRE(CurrentVersion(store) == 0);
  }
  SECTION("a model is stored only in place of the one that it was computed from") {
    CHECK(store->PutModel("d", model, {1, first}).status().code() == StatusCode::kAborted);
    CHECK(store->DropModel("d", {1, first}).code() == StatusCode::kAborted);
    REQUIRE(Require(store->PutModel("d", model, {0, first})).version == 1);
    CHECK(store->PutModel("d", model, {0, first}).status().code() == StatusCode::kAborted);
    const core::Model extended = ExtendedBy(model, run);
    CHECK(store->PutExtension("d", extended, 0, {2, first}).status().code() ==
          StatusCode::kAborted);
    REQUIRE(Require(store->PutExtension("d", extended, 0, {1, first})).version == 2);
    CHECK(store->PutModel("d", model, {1, first}).status().code() == StatusCode::kAborted);
    CHECK(store->DropModel("d", {1, first}).code() == StatusCode::kAborted);
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), extended));
    // After the model was dropped, there is none to replace.
    REQUIRE_OK(store->DropModel("d", {2, first}));
    CHECK(store->PutModel("d", model, {2, first}).status().code() == StatusCode::kAborted);
    REQUIRE(Require(store->PutModel("d", model, {0, first})).version == 3);
  }
  SECTION("the lease of a deleted database does not pass to one of its name") {
    REQUIRE_OK(store->DeleteDatabase("d"));
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    REQUIRE_OK(store->AcquireBuildLease("d", "b", kLong));
  }
}

void TestRandomBuilders(StoreUnderTest& store, unsigned seed, int steps) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  const NewClip walk = SampleClip("d", "walk", 1);
  REQUIRE_OK(store->AddClip(walk));
  const core::Model model = SampleModel({walk});

  struct Builder {
    std::int64_t fence = 0;
    int version = 0;  // of the model that it computes from
  };
  std::array<Builder, 3> builders;
  int holder = -1;  // -1: none
  bool has_expired = false;
  std::int64_t last_fence = 0;
  int current = 0;
  int last_version = 0;
  std::mt19937 random(seed);
  for (int step = 0; step < steps; ++step) {
    const int b = static_cast<int>(random() % builders.size());
    Builder& builder = builders[static_cast<std::size_t>(b)];
    const bool expires = random() % 2 == 0;
    const std::chrono::milliseconds duration = expires ? kExpired : kLong;
    const bool is_last = builder.fence == last_fence;
    const auto action = random() % 6;
    INFO("seed " << seed << ", step " << step << ": builder " << b << ", action " << action);
    if (action == 0) {
      const auto acquired =
          store->AcquireBuildLease("d", std::string(1, static_cast<char>('a' + b)), duration);
      const bool is_free = holder == -1 || holder == b || has_expired;
      REQUIRE(acquired.ok() == is_free);
      if (!is_free) continue;
      REQUIRE(*acquired > last_fence);
      builder.fence = last_fence = *acquired;
      holder = b;
      has_expired = expires;
    } else if (action == 1) {
      const bool renews = is_last && holder == b;
      REQUIRE(store->RenewBuildLease("d", builder.fence, duration).ok() == renews);
      if (renews) has_expired = expires;
    } else if (action == 2) {
      REQUIRE_OK(store->ReleaseBuildLease("d", builder.fence));
      if (is_last && holder == b) holder = -1;
    } else if (action == 3) {
      builder.version = CurrentVersion(store);
      REQUIRE(builder.version == current);
    } else if (action == 4) {
      const auto put = store->PutModel("d", model, {builder.version, builder.fence});
      const bool stores = is_last && builder.version == current;
      REQUIRE(put.ok() == stores);
      if (!stores) {
        REQUIRE(put.status().code() == StatusCode::kAborted);
        continue;
      }
      REQUIRE(put->version == ++last_version);
      current = builder.version = last_version;
    } else {
      const absl::Status dropped = store->DropModel("d", {builder.version, builder.fence});
      const bool drops = is_last && builder.version == current;
      REQUIRE(dropped.ok() == drops);
      if (drops) current = builder.version = 0;
    }
  }
}

void TestReadExtension(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  const std::vector<NewClip> clips{SampleClip("d", "walk", 1), SampleClip("d", "run", 2),
                                   SampleClip("d", "jump", 3), SampleClip("d", "hop", 4)};
  for (const NewClip& clip : clips) REQUIRE_OK(store->AddClip(clip));
  const core::Model built = SampleModel({clips[0], clips[1]});
  REQUIRE_ERROR(store->ReadExtension(kUnknown, 1, built, core::RunSerially), StatusCode::kNotFound,
                kUnknown);
  REQUIRE_ERROR(store->ReadExtension("d", 1, built, core::RunSerially), StatusCode::kNotFound, "d");
  REQUIRE_OK(store->PutModel("d", built));
  const core::Model second = ExtendedBy(built, clips[2]);
  REQUIRE_OK(store->PutExtension("d", second, 0));
  const core::Model third = ExtendedBy(second, clips[3]);
  REQUIRE_OK(store->PutExtension("d", third, 0));
  const auto is_third = [&](const absl::StatusOr<core::Model>& read) {
    REQUIRE(Require(read).states() == third.states());
    REQUIRE(read->tree().frame_order() == third.tree().frame_order());
    REQUIRE(read->clips().size() == 4);
  };
  is_third(store->ReadExtension("d", 1, built, core::RunSerially));
  is_third(store->ReadExtension("d", 2, second, core::RunSerially));
  is_third(store->ReadExtension("d", 3, third, core::RunSerially));
  REQUIRE_OK(store->PutModel("d", SampleModel({clips[0], clips[1], clips[2]})));
  for (const auto& [version, base] : {std::pair(1, &built), {2, &second}, {3, &third}}) {
    REQUIRE_ERROR(store->ReadExtension("d", version, *base, core::RunSerially),
                  StatusCode::kFailedPrecondition, "extend");
  }
}

void TestDatabaseStates(StoreUnderTest& store) {
  REQUIRE(Require(store->ListDatabaseStates()).empty());
  auto database = SampleDatabase("d");
  database.marker_set_text = "first";
  REQUIRE_OK(store->CreateDatabase(database));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("c")));
  const auto of_d = [&] {
    const auto states = Require(store->ListDatabaseStates());
    REQUIRE(states.size() == 2);
    REQUIRE(states[0].name == "c");
    REQUIRE(states[1].name == "d");
    return states[1];
  };
  const auto created = of_d();
  REQUIRE(of_d().stamp == created.stamp);
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
  const auto filled = of_d();
  REQUIRE(filled.id == created.id);
  REQUIRE(filled.stamp != created.stamp);
  REQUIRE(filled.revision == Require(store->annotations().Revision("d")));
  REQUIRE_OK(store->PutModel("d", SampleModel({SampleClip("d", "walk", 1)})));
  const auto modelled = of_d();
  REQUIRE(modelled.revision > filled.revision);
  REQUIRE(modelled.stamp != filled.stamp);
  REQUIRE_OK(store->ReplaceMarkerSet("d", "first", "second"));
  REQUIRE(of_d().stamp != modelled.stamp);
  REQUIRE(of_d().revision == modelled.revision);
}

}  // namespace motiondb::tests
