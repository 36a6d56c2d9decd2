// A simulated disk with faults: an SQLite VFS on top of the system's. It counts writes, syncs and
// truncations, makes one of them fail, makes a sector unreadable, and simulates a power cut: each
// change without a later sync is kept, lost, or torn at sector boundaries, in any order. Deleting a
// file is durable immediately.
//
// Only one per process; not thread-safe.
#pragma once

#include <sqlite3.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace motiondb::tests {

class FaultDisk {
 public:
  enum class Fault {
    kNone,
    kError,       // the operation fails without effect; later ones succeed
    kShortWrite,  // the operation fails after half of the write; later ones succeed
    kFull,        // this write and all later ones fail (disk full), until Clear
    kPowerCut,    // every operation fails, until Reboot
  };

  static constexpr char kVfs[] = "fault";

  FaultDisk();
  ~FaultDisk();
  FaultDisk(const FaultDisk&) = delete;
  FaultDisk& operator=(const FaultDisk&) = delete;

  // Forgets all files. The fault occurs at operation number `at` from now, counted from 1.
  void Arm(Fault fault, int at);
  void Clear() { fault_ = Fault::kNone; }
  void CutPower() { dead_ = true; }
  // Until Arm, reads that include this byte fail with `code`. SQLite's VFS returns
  // SQLITE_IOERR_CORRUPTFS for EIO, and SQLITE_IOERR_READ for most other errors.
  void LoseSector(const std::string& path, std::int64_t byte, int code) {
    bad_sectors_[path] = {byte, code};
  }
  // Delays each later read by a millisecond.
  void SlowDown() { slow_ = true; }
  // Number of reads since construction. Any thread may call it.
  int reads() const { return reads_; }
  // Number of operations since Arm.
  int operations() const { return operations_; }
  bool struck() const { return struck_; }
  // The files, by path, that the disk has after a power cut; `seed` chooses what it kept. Each seed
  // may be tried after the same cut.
  using Contents = std::map<std::string, std::string>;
  Contents AfterPowerCut(unsigned seed) const;
  // With all files closed: sets the files that were opened to `kept` and ends the fault.
  void Reboot(const Contents& kept);
  void Reboot(unsigned seed) { Reboot(AfterPowerCut(seed)); }

  // Called by the VFS for each operation. They return an SQLite result code.
  int OnRead(const std::string& path, std::int64_t offset, int count);
  int OnWrite(const std::string& path, std::int64_t offset, const char* bytes, int count,
              int& done);
  int OnTruncate(const std::string& path, std::int64_t size);
  int OnSync(const std::string& path);
  void OnOpen(const std::string& path);
  void OnDelete(const std::string& path) { files_.erase(path); }
  bool dead() const { return dead_; }

 private:
  // A change of a file since its last sync.
  struct Change {
    std::int64_t offset = 0;  // offset of a write, or the new size
    std::string bytes;
    bool truncates = false;
  };
  struct File {
    bool durable = false;  // whether the file certainly exists after a power cut
    std::string synced;    // its content at the last sync
    std::vector<Change> unsynced;
  };

  // Counts an operation and returns whether the fault occurs in it.
  bool Strikes();
  static void Apply(const Change& change, std::string& bytes);
  static void Tear(const Change& change, std::string& bytes, std::mt19937& random);

  sqlite3_vfs vfs_;
  std::map<std::string, File> files_;
  struct BadSector {
    std::int64_t byte = 0;  // offset of a byte in the sector
    int code = SQLITE_OK;
  };
  std::map<std::string, BadSector> bad_sectors_;  // by file
  Fault fault_ = Fault::kNone;
  int at_ = 0;
  int operations_ = 0;
  bool struck_ = false;
  bool dead_ = false;
  bool slow_ = false;
  std::atomic<int> reads_ = 0;
};

}  // namespace motiondb::tests
