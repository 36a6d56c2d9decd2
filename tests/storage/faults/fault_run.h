// Injects every disk fault at every write and sync of a change of a store.
//
// MOTIONDB_FAULT_SEEDS: number of power cuts at each operation; default 8.
// MOTIONDB_FAULT_STRIDE: each fault happens at each n-th operation only, different faults at
// different ones; default 1.
// MOTIONDB_FAULT_PARTS, MOTIONDB_FAULT_PART: only the cases of this part, from 1, of so many.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "tests/storage/faults/fault_disk.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests {

// The clock of stores with faults.
inline constexpr std::int64_t kFaultTime = 1'700'000'000'000'000;

// Of a store on the disk `vfs`; empty: that of the system.
inline storage::SqliteOptions FaultOptions(const std::string& vfs) {
  return {.reader_count = 1, .now_us = [] { return kFaultTime; }, .vfs = vfs};
}

// A change of a store. Opening the store is part of it.
struct FaultyChange {
  std::string before;  // bytes of the file before the change
  std::function<absl::Status(storage::MotionStore&)> change;
  // Completes an interrupted change and checks the effects that a dump does not show.
  std::function<void(storage::MotionStore&, const StoreFile&)> rest;
};

// Injects every fault at every disk operation of a change.
class FaultRun {
 public:
  explicit FaultRun(FaultyChange change) : change_(std::move(change)) {
    Begin(Fault::kNone, 0);
    {
      const auto store = Require(file_.TryOpen(FaultOptions("")));
      before_ = Dump(*store);
    }
    Begin(Fault::kNone, 0);
    {
      const auto store = Require(file_.TryOpen(FaultOptions(FaultDisk::kVfs)));
      REQUIRE_OK(change_.change(*store));
    }
    operations_ = disk_.operations();
    const auto store = Require(file_.TryOpen(FaultOptions("")));
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

  // Returns the number in an environment variable, at least 1.
  static int Variable(const char* name, int otherwise) {
    const char* const text = std::getenv(name);
    return text == nullptr ? otherwise : std::max(1, std::atoi(text));
  }

  int cases() const { return cases_; }
  // Returns whether the dumps before and after the change differ.
  bool is_seen() const { return before_ != after_; }

 private:
  using Fault = FaultDisk::Fault;
  using Store = storage::MotionStore;

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
    for (const char* const suffix : kSuffixes) std::filesystem::remove(file_.path() + suffix);
    std::ofstream(file_.path(), std::ios::binary | std::ios::trunc) << change_.before;
    disk_.Arm(fault, at);
    ++cases_;
  }

  // Opens, changes and closes the store. Returns the status of opening or of the change.
  absl::Status Run(const std::function<void(Store&, const absl::Status&)>& then = {}) {
    auto store = file_.TryOpen(FaultOptions(FaultDisk::kVfs));
    if (!store.ok()) return store.status();
    const absl::Status changed = change_.change(**store);
    if (then) then(**store, changed);
    return changed;
  }

  // Checks the files that the store has left. Equal files are checked once.
  void CheckAfterwards(const std::string& what, bool may_be_before, bool may_be_after) {
    std::string remains;
    for (const char* const suffix : kSuffixes) {
      const std::string path = file_.path() + suffix;
      const bool exists = std::filesystem::exists(path);
      const std::string bytes = exists ? ReadFile(path) : "";
      remains += exists ? std::to_string(bytes.size()) : "none";
      remains += ":" + std::to_string(std::hash<std::string>()(bytes)) + ",";
    }
    if (!checked_.emplace(remains, may_be_before, may_be_after).second) return;
    INFO(what);
    const auto store = Require(file_.TryOpen(FaultOptions("")));
    const std::string found = Findings(*store);
    INFO(found);
    REQUIRE(found.empty());
    const std::string dump = Dump(*store);
    const bool right = (may_be_before && dump == before_) || (may_be_after && dump == after_);
    REQUIRE(right);
    if (change_.rest) change_.rest(*store, file_);
  }

  // Tries different remains of one power cut.
  void CutPowerAt(int at) {
    Begin(Fault::kPowerCut, at);
    const absl::Status changed = Run();
    const auto seeds = static_cast<unsigned>(Variable("MOTIONDB_FAULT_SEEDS", 8));
    for (unsigned seed = 0; seed < seeds; ++seed) {
      ++cases_;
      disk_.Reboot(disk_.AfterPowerCut(static_cast<unsigned>(at) * seeds + seed));
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
    if (!changed.ok() && Dump(*Require(file_.TryOpen(FaultOptions("")))) == before_) {
      REQUIRE_OK(Run());  // the store could not be opened before
    }
    CheckAfterwards("full at " + std::to_string(at), false, true);
  }

  static constexpr const char* kSuffixes[] = {"", "-wal", "-shm", "-journal"};

  const StoreFile file_;
  FaultDisk disk_;
  const FaultyChange change_;
  std::string before_;
  std::string after_;
  int operations_ = 0;
  int cases_ = 0;
  int fault_count_ = 0;
  int case_count_ = 0;  // of all parts
  std::set<std::tuple<std::string, bool, bool>> checked_;
};

}  // namespace motiondb::tests
