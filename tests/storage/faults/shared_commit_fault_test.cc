// Disk faults while clips share a commit: a clip is stored exactly if its caller got OK.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/storage/add_together.h"
#include "tests/storage/faults/fault_disk.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::shared_commit_fault_test {
namespace {

using Fault = FaultDisk::Fault;

class SharedCommitRun {
 public:
  SharedCommitRun() {
    {
      const auto store = file_.Open();
      REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    }
    before_ = ReadFile(file_.path());
    for (unsigned i = 0; i < 3; ++i) {
      clips_.push_back(SampleClip("d", "clip-" + std::to_string(i), 10 + i));
      clips_.back().audit = [](const storage::ClipRecord&) {
        return storage::AuditRecord{.method = "Ingest"};
      };
    }
  }

  // Returns the number of disk operations for opening the store, adding the clips and closing it.
  int Operations() {
    for (const AddResult& answer : AddUnder(Fault::kNone, 0)) REQUIRE_OK(answer.added);
    return disk_.operations();
  }

  void FailAt(Fault fault, int at) {
    INFO("fault " << static_cast<int>(fault) << " at " << at);
    const auto answers = AddUnder(fault, at);
    const bool is_cut = fault == Fault::kPowerCut;
    if (is_cut) disk_.Reboot(static_cast<unsigned>(at));
    const auto store = file_.Open();
    REQUIRE(Findings(*store).empty());
    for (std::size_t i = 0; i < clips_.size(); ++i) {
      const bool acknowledged = i < answers.size() && answers[i].added.ok();
      const bool found = store->GetClip("d", clips_[i].record.id).ok();
      // A clip that was being written during the power cut may be stored.
      REQUIRE((found == acknowledged || (found && is_cut)));
    }
    // Each stored clip, including the holder, has its audit entry.
    REQUIRE(Require(store->access().ListAuditRecords(0, 100)).size() ==
            Require(store->ListClips("d", {})).size());
  }

 private:
  // Empty if the store could not be opened.
  std::vector<AddResult> AddUnder(Fault fault, int at) {
    for (const char* const suffix : {"-wal", "-shm", "-journal"}) {
      std::filesystem::remove(file_.path() + suffix);
    }
    std::ofstream(file_.path(), std::ios::binary | std::ios::trunc) << before_;
    disk_.Arm(fault, at);
    std::vector<AddResult> answers;
    {
      const auto store = file_.TryOpen({.reader_count = 1, .now_us = {}, .vfs = FaultDisk::kVfs});
      if (store.ok()) {
        answers = AddTogether(**store, holder_, clips_, std::chrono::milliseconds(5));
      }
    }
    if (fault == Fault::kFull) disk_.Clear();
    return answers;
  }

  const StoreFile file_;
  FaultDisk disk_;
  std::string before_;
  const storage::NewClip holder_ = SampleClip("d", "holder", 1);
  std::vector<storage::NewClip> clips_;
};

}  // namespace

TEST_CASE("Faults: clips that share a commit", "[storage][power]") {
  SharedCommitRun run;
  const int operations = run.Operations();
  REQUIRE(operations > 10);
  for (const Fault fault : {Fault::kPowerCut, Fault::kError, Fault::kShortWrite, Fault::kFull}) {
    for (int at = 1; at <= operations; ++at) run.FailAt(fault, at);
  }
}

}  // namespace motiondb::tests::shared_commit_fault_test
