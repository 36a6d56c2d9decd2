// A disk that fails when a test says so: a SQLite VFS over the system's own, which counts writes,
// syncs and truncations, lets one of them go wrong, loses a sector, and remembers what was not
// synced yet, so that it can leave the files as a power cut would: of what no sync followed, each
// write is there, or not, or torn at sectors, in any order. Deleting a file is taken as durable at
// once.
//
// One at a time in a process; not thread-safe.
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
    kError,       // the operation fails and does nothing; those after it work
    kShortWrite,  // the operation fails half done; those after it work
    kFull,        // it and all writes after it find no room, until Clear
    kPowerCut,    // nothing works from then on, until Reboot
  };

  static constexpr char kVfs[] = "fault";

  FaultDisk();
  ~FaultDisk();
  FaultDisk(const FaultDisk&) = delete;
  FaultDisk& operator=(const FaultDisk&) = delete;

  // Forgets all files. The fault happens at operation number `at` from now, counted from 1.
  void Arm(Fault fault, int at);
  void Clear() { fault_ = Fault::kNone; }
  void CutPower() { dead_ = true; }
  // Whatever is read together with this byte cannot be read from now on, until Arm: `code` instead.
  // SQLite has EIO as SQLITE_IOERR_CORRUPTFS, most others as SQLITE_IOERR_READ.
  void LoseSector(const std::string& path, std::int64_t byte, int code) {
    bad_sectors_[path] = {byte, code};
  }
  // Each read takes a millisecond from now on.
  void SlowDown() { slow_ = true; }
  // Since the disk was made. From any thread.
  int reads() const { return reads_; }
  // Operations since Arm.
  int operations() const { return operations_; }
  bool struck() const { return struck_; }
  // After a power cut, with every file closed: makes the files what the disk kept, as `seed` has
  // it, and works again.
  void Reboot(unsigned seed);

  // What the VFS asks on each operation: a result code.
  int OnRead(const std::string& path, std::int64_t offset, int count);
  int OnWrite(const std::string& path, std::int64_t offset, const char* bytes, int count,
              int& done);
  int OnTruncate(const std::string& path, std::int64_t size);
  int OnSync(const std::string& path);
  void OnOpen(const std::string& path);
  void OnDelete(const std::string& path) { files_.erase(path); }
  bool dead() const { return dead_; }

 private:
  // What was done to a file since its last sync.
  struct Change {
    std::int64_t offset = 0;  // of a write, or the size truncated to
    std::string bytes;
    bool truncates = false;
  };
  struct File {
    bool durable = false;  // whether there is a file after a power cut, for certain
    std::string synced;    // its bytes then
    std::vector<Change> unsynced;
  };

  // Whether the operation that now begins is the one that goes wrong.
  bool Strikes();
  static void Apply(const Change& change, std::string& bytes);
  static void Tear(const Change& change, std::string& bytes, std::mt19937& random);

  sqlite3_vfs vfs_;
  std::map<std::string, File> files_;
  struct BadSector {
    std::int64_t byte = 0;  // one that lies in it
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
