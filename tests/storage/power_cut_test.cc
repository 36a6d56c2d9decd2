// Disk faults at every write and sync of each kind of change: acknowledged changes stay, others
// leave no trace, and nothing is corrupt.
//
// MOTIONDB_FAULT_SEEDS: number of power cuts at each operation; default 8.
// MOTIONDB_FAULT_STRIDE: each fault happens at each n-th operation only, different faults at
// different ones; default 1.
// MOTIONDB_FAULT_PARTS, MOTIONDB_FAULT_PART: only the cases of this part, from 1, of so many.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/model/extend_model.h"
#include "tests/storage/backup_bytes.h"
#include "tests/storage/fault_disk.h"
#include "tests/storage/old_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::power_cut_test {
namespace {

using Fault = FaultDisk::Fault;
using Store = storage::MotionStore;

constexpr std::int64_t kNow = 1'700'000'000'000'000;

int Variable(const char* name, int otherwise) {
  const char* const text = std::getenv(name);
  return text == nullptr ? otherwise : std::max(1, std::atoi(text));
}

storage::SqliteOptions Options(const std::string& vfs) {
  return {.reader_count = 1, .now_us = [] { return kNow; }, .vfs = vfs};
}

// A change of a store. Opening the store is part of it.
struct Change {
  std::string before;  // bytes of the file before the change
  std::function<absl::Status(Store&)> change;
  // Completes an interrupted change and checks the effects that a dump does not show.
  std::function<void(Store&, const StoreFile&)> rest;
};

// Returns the bytes of a store with the content that `fill` adds.
std::string FileOf(const std::function<void(Store&)>& fill) {
  const StoreFile file;
  fill(*file.Open(Options("")));
  return ReadFile(file.path());
}

void FillWithModel(Store& store) {
  REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store.AddClip(SampleClip("d", "walk", 1)));
  REQUIRE_OK(store.AddClip(SampleClip("d", "run", 2)));
  REQUIRE_OK(store.PutModel("d", SampleModel({SampleClip("d", "walk", 1)})));
  REQUIRE_OK(store.PutOperation(SampleOperation("d", "first")));
}

core::Model Extended() {
  const auto run = SampleClip("d", "run", 2);
  std::vector<core::BuildInput> inputs;
  inputs.push_back({run.record.id, run.record.label, run.states, run.record.subject});
  return Require(core::ExtendModel(SampleModel({SampleClip("d", "walk", 1)}), std::move(inputs),
                                   core::RunSerially));
}

// The audit entry of a change: stored with the change, or neither is stored.
const storage::AuditRecord kEntry{.time_us = kNow, .method = "Change"};

// Injects every fault at every disk operation of a change.
class FaultRun {
 public:
  explicit FaultRun(Change change) : change_(std::move(change)) {
    Begin(Fault::kNone, 0);
    {
      const auto store = Require(file_.TryOpen(Options("")));
      before_ = Dump(*store);
    }
    Begin(Fault::kNone, 0);
    {
      const auto store = Require(file_.TryOpen(Options(FaultDisk::kVfs)));
      REQUIRE_OK(change_.change(*store));
    }
    operations_ = disk_.operations();
    const auto store = Require(file_.TryOpen(Options("")));
    after_ = Dump(*store);
  }

  void CutPowerEverywhere() {
    Everywhere([&](int at) { CutPowerAt(at); });
  }

  void FailEverywhere() {
    for (const Fault fault : {Fault::kError, Fault::kShortWrite}) {
      for (const bool power_goes_too : {false, true}) {
        Everywhere([&](int at) { FailAt(fault, at, power_goes_too); });
      }
    }
  }

  void FillEverywhere() {
    Everywhere([&](int at) { FillAt(at); });
  }

  int cases() const { return cases_; }
  // Returns whether the dumps before and after the change differ.
  bool is_seen() const { return before_ != after_; }

 private:
  // Injects a fault at each operation, or at each n-th (MOTIONDB_FAULT_STRIDE).
  void Everywhere(const std::function<void(int at)>& inject) {
    const int stride = Variable("MOTIONDB_FAULT_STRIDE", 1);
    const int parts = Variable("MOTIONDB_FAULT_PARTS", 1);
    const int part = Variable("MOTIONDB_FAULT_PART", 1);
    for (int at = 1 + fault_count_++ % stride; at <= operations_; at += stride) {
      if (case_count_++ % parts == part - 1) inject(at);
    }
  }

  // Restores the file before the change and arms the disk.
  void Begin(Fault fault, int at) {
    for (const char* const suffix : {"-wal", "-shm", "-journal"}) {
      std::filesystem::remove(file_.path() + suffix);
    }
    std::ofstream(file_.path(), std::ios::binary | std::ios::trunc) << change_.before;
    disk_.Arm(fault, at);
    ++cases_;
  }

  // Opens, changes and closes the store. Returns the status of opening or of the change.
  absl::Status Run(const std::function<void(Store&, const absl::Status&)>& then = {}) {
    auto store = file_.TryOpen(Options(FaultDisk::kVfs));
    if (!store.ok()) return store.status();
    const absl::Status changed = change_.change(**store);
    if (then) then(**store, changed);
    return changed;
  }

  void CheckAfterwards(const std::string& what, bool may_be_before, bool may_be_after) {
    INFO(what);
    const auto store = Require(file_.TryOpen(Options("")));
    const std::string found = Findings(*store);
    INFO(found);
    REQUIRE(found.empty());
    const std::string dump = Dump(*store);
    const bool right = (may_be_before && dump == before_) || (may_be_after && dump == after_);
    REQUIRE(right);
    if (change_.rest) change_.rest(*store, file_);
  }

  // Tries different remains of one power cut. Equal remains are checked once.
  void CutPowerAt(int at) {
    Begin(Fault::kPowerCut, at);
    const absl::Status changed = Run();
    std::set<FaultDisk::Contents> checked;
    const auto seeds = static_cast<unsigned>(Variable("MOTIONDB_FAULT_SEEDS", 8));
    for (unsigned seed = 0; seed < seeds; ++seed) {
      const auto kept = disk_.AfterPowerCut(static_cast<unsigned>(at) * seeds + seed);
      ++cases_;
      if (!checked.insert(kept).second) continue;
      disk_.Reboot(kept);
      CheckAfterwards("power cut at " + std::to_string(at) + ", seed " + std::to_string(seed),
                      !changed.ok(), true);
    }
  }

  void FailAt(Fault fault, int at, bool power_goes_too) {
    Begin(fault, at);
    const absl::Status changed = Run([&](Store& store, const absl::Status& status) {
      if (!status.ok()) {
        INFO(status);
        CHECK(absl::IsUnavailable(status));
        CHECK(Dump(store) == before_);
      }
      if (power_goes_too) disk_.CutPower();
    });
    if (power_goes_too) disk_.Reboot(static_cast<unsigned>(at));
    // A commit whose sync failed is rolled back in the running process. If the power is cut before
    // the next commit, the log may still contain it: completely, never in part.
    CheckAfterwards("fault " + std::to_string(static_cast<int>(fault)) + " at " +
                        std::to_string(at) + (power_goes_too ? ", then power" : ""),
                    !changed.ok(), changed.ok() || power_goes_too);
  }

  void FillAt(int at) {
    Begin(Fault::kFull, at);
    const absl::Status changed = Run([&](Store& store, const absl::Status& status) {
      if (!status.ok()) {
        INFO(status);
        CHECK(absl::IsResourceExhausted(status));
        CHECK(Dump(store) == before_);
      }
      disk_.Clear();
      if (!status.ok()) REQUIRE_OK(change_.change(store));  // the disk has room again
    });
    disk_.Clear();
    if (!changed.ok() && Dump(*Require(file_.TryOpen(Options("")))) == before_) {
      REQUIRE_OK(Run());  // the store could not be opened before
    }
    CheckAfterwards("full at " + std::to_string(at), false, true);
  }

  const StoreFile file_;
  FaultDisk disk_;
  const Change change_;
  std::string before_;
  std::string after_;
  int operations_ = 0;
  int cases_ = 0;
  int fault_count_ = 0;
  int case_count_ = 0;  // of all parts
};

void RunAll(Change change, bool is_seen = true) {
  FaultRun run(std::move(change));
  REQUIRE(run.is_seen() == is_seen);
  run.CutPowerEverywhere();
  run.FailEverywhere();
  run.FillEverywhere();
  REQUIRE(run.cases() * Variable("MOTIONDB_FAULT_STRIDE", 1) * Variable("MOTIONDB_FAULT_PARTS", 1) >
          100);
}

}  // namespace

TEST_CASE("Faults: creation of a store", "[storage][power]") {
  RunAll({"", [](Store& store) { return store.CreateDatabase(SampleDatabase("d"), {&kEntry}); }});
}

TEST_CASE("Faults: an ingest", "[storage][power]") {
  auto clip = SampleClip("d", "jump", 3);
  clip.skeleton = SampleSkeleton("other");
  clip.audit = [](const storage::ClipRecord& stored) {
    auto entry = kEntry;
    entry.resource = stored.id;
    return entry;
  };
  RunAll({FileOf(FillWithModel), [clip](Store& store) { return store.AddClip(clip).status(); }});
}

TEST_CASE("Faults: an edit", "[storage][power]") {
  std::vector<storage::Change> changes;
  storage::ClipChange title;
  title.clip = "walk";
  title.title = "Title";
  changes.emplace_back(title);
  storage::SegmentCreation segment;
  segment.segment.clip = "walk";
  segment.segment.id = "step";
  segment.segment.end_seconds = 0.5;
  changes.emplace_back(segment);
  RunAll({FileOf(FillWithModel), [changes](Store& store) {
            return store.annotations().Edit("d", changes, "me", {&kEntry}).status();
          }});
}

TEST_CASE("Faults: a rebuild", "[storage][power]") {
  const core::Model model = SampleModel({SampleClip("d", "run", 2), SampleClip("d", "walk", 1)});
  RunAll({FileOf(FillWithModel),
          [model](Store& store) { return store.PutModel("d", model).status(); }});
}

TEST_CASE("Faults: results of deriving clips again", "[storage][power]") {
  const auto derived = [](Store& store) {
    storage::DerivedClip walk{.record = Require(store.GetClip("d", "walk")),
                              .states = SampleStates(50, 9)};
    walk.record.frame_count = 50;
    walk.record.source_report = "derived again";
    storage::DerivedClip run{.record = Require(store.GetClip("d", "run"))};
    run.record.derive_error = "cannot be read";
    return std::vector{walk, run};
  };
  std::vector<storage::DerivedClip> clips;
  const std::string before = FileOf([&](Store& store) {
    FillWithModel(store);
    clips = derived(store);
  });
  // The current model keeps the replaced states.
  const auto rest = [](Store& store, const StoreFile&) {
    REQUIRE(Same(Require(store.ReadModel("d", core::RunSerially)),
                 SampleModel({SampleClip("d", "walk", 1)})));
  };
  RunAll({before, [clips](Store& store) { return store.PutDerived("d", clips).status(); }, rest});
}

TEST_CASE("Faults: dropping a model", "[storage][power]") {
  // Only the model uses the deleted clip.
  const auto fill = [](Store& store) {
    FillWithModel(store);
    REQUIRE_OK(store.DeleteClip("d", "walk"));
  };
  const auto rest = [](Store& store, const StoreFile& file) {
    REQUIRE_OK(store.DropModel("d"));
    REQUIRE(file.Sql("SELECT count(DISTINCT clip_key) FROM clip_chunk") == "1");
    REQUIRE(Findings(store).empty());
  };
  RunAll({FileOf(fill), [](Store& store) { return store.DropModel("d"); }, rest});
}

TEST_CASE("Faults: the end of an operation", "[storage][power]") {
  auto ended = SampleOperation("d", "first");
  ended.state = storage::OperationState::kSucceeded;
  ended.progress = 1;
  ended.stage = "done";
  ended.model_version = 1;
  ended.update_time_us = kNow + 1;
  RunAll({FileOf(FillWithModel), [ended](Store& store) { return store.PutOperation(ended); }});
}

TEST_CASE("Faults: an extension", "[storage][power]") {
  const core::Model model = Extended();
  RunAll({FileOf(FillWithModel),
          [model](Store& store) { return store.PutExtension("d", model, 0.1).status(); }});
}

TEST_CASE("Faults: deletion", "[storage][power]") {
  SECTION("of a clip that the model uses") {
    RunAll({FileOf(FillWithModel),
            [](Store& store) { return store.DeleteClip("d", "walk", {&kEntry}).status(); }});
  }
  SECTION("of a clip that the model does not use") {
    RunAll({FileOf(FillWithModel),
            [](Store& store) { return store.DeleteClip("d", "run", {&kEntry}).status(); }});
  }
  SECTION("of a database") {
    RunAll(
        {FileOf(FillWithModel), [](Store& store) { return store.DeleteDatabase("d", {&kEntry}); }});
  }
  SECTION("of the content of a deleted database") {
    const auto fill = [](Store& store) {
      FillWithModel(store);
      REQUIRE_OK(store.DeleteDatabase("d", {&kEntry}));
      REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
      REQUIRE_OK(store.AddClip(SampleClip("d", "jump", 3)));
    };
    const auto rest = [](Store& store, const StoreFile& file) {
      REQUIRE_OK(store.PurgeDeletedDatabases({}));
      REQUIRE(file.Sql("SELECT count(*) FROM database") == "1");
      REQUIRE(file.Sql("SELECT count(DISTINCT clip_key) FROM clip_chunk") == "1");
      REQUIRE(Findings(store).empty());
    };
    RunAll({FileOf(fill), [](Store& store) { return store.PurgeDeletedDatabases({}); }, rest},
           /*is_seen=*/false);
  }
}

TEST_CASE("Faults: a restore", "[storage][power]") {
  const StoreFile from;
  const auto source = from.Open(Options(""));
  FillWithModel(*source);
  const std::string backup = Backup(*source);
  // The token and the audit entry of the target stay.
  const auto fill = [](Store& store) {
    REQUIRE_OK(store.access().AddToken({.id = "t", .salt = "s", .secret_hash = "h"}, {&kEntry}));
  };
  RunAll({FileOf(fill), [&](Store& store) { return Restore(store, backup); }});
}

TEST_CASE("Faults: an import", "[storage][power]") {
  const StoreFile from;
  const auto source = from.Open(Options(""));
  FillWithModel(*source);
  const std::string exported = Export(*source, "d");
  const auto rest = [](Store& store, const StoreFile& file) {
    REQUIRE_OK(store.PurgeDeletedDatabases({}));
    const bool is_imported = store.GetDatabase("copy").ok();
    REQUIRE(file.Sql("SELECT count(*) FROM database") == (is_imported ? "2" : "1"));
    REQUIRE(file.Sql("SELECT count(DISTINCT clip_key) FROM clip_chunk") ==
            file.Sql("SELECT count(*) FROM clip"));
    REQUIRE(Findings(store).empty());
  };
  RunAll({FileOf(FillWithModel),
          [&](Store& store) { return Import(store, exported, "copy", &kEntry); }, rest});
}

TEST_CASE("Faults: a token", "[storage][power]") {
  const auto add = [](Store& store) {
    return store.access().AddToken({.id = "t", .salt = "s", .secret_hash = "h"}, {&kEntry});
  };
  SECTION("that is created") { RunAll({FileOf(FillWithModel), add}); }
  SECTION("that is revoked") {
    const auto fill = [add](Store& store) {
      FillWithModel(store);
      REQUIRE_OK(add(store));
    };
    RunAll({FileOf(fill), [](Store& store) {
              return store.access().RevokeToken("t", kNow, {&kEntry}).status();
            }});
  }
}

TEST_CASE("Faults: a migration", "[storage][power][migration]") {
  const int version = GENERATE(1, 2, 3, 7);
  RunAll({OldStore(version), [](Store&) { return absl::OkStatus(); }}, /*is_seen=*/false);
}

}  // namespace motiondb::tests::power_cut_test
