// Cancellation of changes that wait for the writer. Catch assertions work on one thread only.
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"
#include "tests/storage/while_writing.h"

namespace motiondb::tests::queue_cancellation_test {
namespace {

// Returns a function that returns true from the third call on.
core::Cancelled AfterAWhile() {
  return [calls = 0]() mutable { return ++calls > 2; };
}

}  // namespace

TEST_CASE("SqliteMotionStore: a change that is cancelled while it waits is not made",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->AddClip(SampleClip("d", "old", 2)));
  REQUIRE_OK(store->AddClip(SampleClip("d", "gone", 3)));
  REQUIRE_OK(store->DeleteClip("d", "gone"));
  REQUIRE_OK(store->access().AddToken({.id = "t"}));
  const storage::AuditRecord record{.method = "Change"};
  WithBlockedWriter(*store, SampleClip("d", "holder", 100), [&] {
    const auto terms = [&] { return storage::WriteOptions{&record, AfterAWhile()}; };
    CHECK(absl::IsCancelled(store->CreateDatabase(SampleDatabase("e"), terms())));
    CHECK(absl::IsCancelled(store->DeleteDatabase("d", terms())));
    CHECK(absl::IsCancelled(store->DeleteClip("d", "old", terms()).status()));
    CHECK(absl::IsCancelled(store->access().AddToken({.id = "u"}, terms())));
    CHECK(absl::IsCancelled(store->access().RevokeToken("t", 1, terms()).status()));
    CHECK(absl::IsCancelled(store->PurgeDeletedClips("d", AfterAWhile())));
    CHECK(absl::IsCancelled(store->PutOperation(SampleOperation("d", "op"), AfterAWhile())));
    storage::NewClip clip = SampleClip("d", "new", 3);
    clip.cancelled = AfterAWhile();
    CHECK(absl::IsCancelled(store->AddClip(clip).status()));
  });
  CHECK(Require(store->ListDatabases({})).size() == 1);
  const auto clips = Require(store->ListClips("d", {}));
  REQUIRE(clips.size() == 2);
  CHECK(clips[0].id == "holder");
  CHECK(clips[1].id == "old");
  const auto tokens = Require(store->access().ListTokens("", 10));
  REQUIRE(tokens.size() == 1);
  CHECK(tokens[0].revoke_time_us == 0);
  CHECK(Require(store->access().ListAuditRecords(0, 10)).size() == 1);
  CHECK(Require(store->ListOperations("d", "", 10)).empty());
  // The cancelled clip can be added.
  REQUIRE_OK(store->AddClip(SampleClip("d", "new", 3)));
}

TEST_CASE("SqliteMotionStore: a cancelled clip is stored exactly if its caller got OK",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  constexpr unsigned kWriters = 4;
  constexpr unsigned kRounds = 12;
  std::vector<std::vector<storage::NewClip>> clips(kWriters);
  for (unsigned w = 0; w < kWriters; ++w) {
    for (unsigned r = 0; r < kRounds; ++r) {
      const unsigned i = kRounds * w + r;
      clips[w].push_back(SampleClip("d", "clip-" + std::to_string(i), i));
      // Some are cancelled immediately, some after a wait.
      clips[w].back().cancelled = [left = static_cast<int>(i % 4)]() mutable {
        return left-- == 0;
      };
    }
  }
  std::vector<std::vector<absl::Status>> results(kWriters);
  std::vector<std::jthread> writers;
  WithBlockedWriter(*store, SampleClip("d", "holder", 100), [&] {
    for (unsigned w = 0; w < kWriters; ++w) {
      writers.emplace_back([&, w] {
        for (const storage::NewClip& clip : clips[w]) {
          results[w].push_back(store->AddClip(clip).status());
        }
      });
    }
    // The first clip of each writer is cancelled during this time.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  });
  writers.clear();
  int cancelled = 0;
  for (unsigned w = 0; w < kWriters; ++w) {
    for (unsigned r = 0; r < kRounds; ++r) {
      INFO(results[w][r]);
      const bool found = store->GetClip("d", clips[w][r].record.id).ok();
      CHECK(found == results[w][r].ok());
      CHECK((found || absl::IsCancelled(results[w][r])));
      cancelled += found ? 0 : 1;
    }
  }
  CHECK(cancelled >= static_cast<int>(kWriters));
}

}  // namespace motiondb::tests::queue_cancellation_test
