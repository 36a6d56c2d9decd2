// Concurrent readers and writers. Catch assertions work on one thread only: other threads count
// errors.
#include <atomic>
#include <barrier>
#include <catch2/catch.hpp>
#include <functional>
#include <new>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/storage/add_together.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::sqlite_concurrency_test {
namespace {

void RunOnThreads(int count, const std::function<void(int)>& body) {
  std::vector<std::jthread> threads;
  for (int i = 0; i < count; ++i) threads.emplace_back(body, i);
}

}  // namespace

TEST_CASE("SqliteMotionStore: a model that is read on several threads is the stored one",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  std::vector<storage::NewClip> clips;
  for (unsigned i = 0; i < 9; ++i) {
    clips.push_back(SampleClip("d", "clip-" + std::to_string(i), i));
    REQUIRE_OK(store->AddClip(clips.back()));
  }
  const core::Model model = SampleModel(clips);
  REQUIRE_OK(store->PutModel("d", model));
  const core::Model read = Require(store->ReadModel("d", RunOnThreads));
  REQUIRE(Same(read, model));
  REQUIRE(read.metric_frames().projected.view() == model.metric_frames().projected.view());
}

TEST_CASE("SqliteMotionStore: readers see consistent data during writes",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open({.reader_count = 3, .now_us = {}, .vfs = {}});
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  const auto first = SampleClip("d", "first", 1);
  REQUIRE_OK(store->AddClip(first));
  const core::Model model = SampleModel({first});
  REQUIRE_OK(store->PutModel("d", model));

  std::atomic<bool> stop = false;
  std::atomic<int> errors = 0;
  std::atomic<int> reads = 0;
  std::vector<std::thread> readers;
  for (int i = 0; i < 6; ++i) {
    readers.emplace_back([&, i] {
      std::size_t clips_before = 0;
      while (!stop) {
        const auto clips = store->ListClips("d", {.after = "", .limit = 1000});
        // An acknowledged clip stays visible, with its states.
        if (!clips.ok() || clips->size() < clips_before) ++errors;
        if (clips.ok() && !clips->empty()) {
          clips_before = clips->size();
          const auto states = store->ReadClipStates("d", (*clips)[i % clips->size()].id);
          if (!states.ok() || states->frame_count() != 60) ++errors;
        }
        const auto read =
            store->ReadModel("d", i % 2 == 0 ? core::ParallelFor(RunOnThreads) : core::RunSerially);
        if (!read.ok() || read->frame_count() != 60) ++errors;
        ++reads;
      }
    });
  }
  for (unsigned i = 2; i < 40; ++i) {
    REQUIRE_OK(store->AddClip(SampleClip("d", "clip", i)));
    REQUIRE_OK(store->PutModel("d", model));
    REQUIRE_OK(store->PutOperation(SampleOperation("d", "op")));
  }
  while (reads < 30) std::this_thread::yield();
  stop = true;
  for (std::thread& reader : readers) reader.join();
  REQUIRE(errors == 0);
  REQUIRE(Require(store->ListClips("d", {})).size() == 39);
  REQUIRE(Require(store->ListModels("d", 0, 1)).at(0).version == 39);
}

TEST_CASE("SqliteMotionStore: concurrent writers all succeed", "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  std::atomic<int> errors = 0;
  std::vector<std::thread> writers;
  for (unsigned w = 0; w < 4; ++w) {
    std::vector<storage::NewClip> clips;
    for (unsigned i = 0; i < 10; ++i) clips.push_back(SampleClip("d", "clip", 100 * w + i));
    writers.emplace_back([&, clips = std::move(clips)] {
      for (const auto& clip : clips) {
        if (!store->AddClip(clip).ok()) ++errors;
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  REQUIRE(errors == 0);
  const auto clips = Require(store->ListClips("d", {.after = "", .limit = 100}));
  REQUIRE(clips.size() == 40);
  REQUIRE(Require(store->GetClip("d", "clip-40")).id == "clip-40");
}

TEST_CASE("SqliteMotionStore: a failing clip in a shared commit does not affect the others",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  constexpr unsigned kWriters = 6;
  constexpr unsigned kRounds = 10;
  // Each motion comes from two writers, except from the last; writer 0 uses a missing database.
  // Made here, because Catch assertions work on one thread only.
  const auto lost = [](unsigned w) { return w == 0; };
  std::vector<std::vector<storage::NewClip>> clips(kWriters);
  for (unsigned w = 0; w < kWriters; ++w) {
    for (unsigned r = 0; r < kRounds; ++r) {
      clips[w].push_back(SampleClip(lost(w) ? "none" : "d", "clip", kWriters * r + (w + 1) / 2));
    }
  }
  std::atomic<int> added = 0, refused = 0, other = 0;
  std::barrier round(kWriters);
  std::vector<std::thread> writers;
  for (unsigned w = 0; w < kWriters; ++w) {
    writers.emplace_back([&, w] {
      for (unsigned r = 0; r < kRounds; ++r) {
        round.arrive_and_wait();
        const auto record = store->AddClip(clips[w][r]);
        if (record.ok()) ++added;
        if (lost(w) ? absl::IsNotFound(record.status()) : absl::IsAlreadyExists(record.status())) {
          ++refused;
        } else if (!record.ok()) {
          ++other;
        }
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  REQUIRE(other == 0);
  REQUIRE(added == 3 * kRounds);
  REQUIRE(refused == 3 * kRounds);
  REQUIRE(Require(store->ListClips("d", {.after = "", .limit = 100})).size() == 3 * kRounds);
}

TEST_CASE("SqliteMotionStore: a throwing clip in a shared commit does not affect the others",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  constexpr unsigned kClips = 4;
  // The last insertion of the shared transaction throws, once or each time that clip is added.
  const bool throws_again = GENERATE(false, true);
  CAPTURE(throws_again);
  std::atomic<unsigned> calls = 0;
  std::atomic<unsigned> bad = kClips;  // which clip
  std::vector<storage::NewClip> clips;
  for (unsigned i = 0; i < kClips; ++i) {
    clips.push_back(SampleClip("d", "clip-" + std::to_string(i), 10 + i));
    clips[i].audit = [&, i](const storage::ClipRecord&) {
      if (++calls == kClips) bad = i;
      if (calls == kClips || (throws_again && bad == i)) throw std::bad_alloc();
      return storage::AuditRecord{.method = "Ingest"};
    };
  }
  const auto answers =
      AddTogether(*store, SampleClip("d", "holder", 1), clips, std::chrono::milliseconds(50));
  REQUIRE(bad < kClips);
  REQUIRE((answers[bad].threw || !throws_again));
  std::size_t stored = 0;
  for (unsigned i = 0; i < kClips; ++i) {
    INFO(i);
    REQUIRE((answers[i].added.ok() || (answers[i].threw && bad == i)));
    // The clip is stored exactly if its caller got OK.
    const bool found = store->GetClip("d", clips[i].record.id).ok();
    REQUIRE(found == answers[i].added.ok());
    if (found) ++stored;
  }
  // The store still works, and the audit log has an entry for each stored clip.
  REQUIRE_OK(store->AddClip(SampleClip("d", "after", 2)));
  REQUIRE(Require(store->access().ListAuditRecords(0, 100)).size() == 1 + stored);
}

TEST_CASE("SqliteMotionStore: the writer is closed after the readers and removes the log",
          "[storage][concurrency]") {
  const StoreFile file;
  {
    const auto store = file.Open();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    REQUIRE_OK(store->GetDatabase("d"));
    REQUIRE(std::filesystem::file_size(file.path() + "-wal") > 0);
  }
  // Only the lock file remains beside the store.
  REQUIRE_FALSE(std::filesystem::exists(file.path() + "-wal"));
  REQUIRE_FALSE(std::filesystem::exists(file.path() + "-shm"));
}

}  // namespace motiondb::tests::sqlite_concurrency_test
