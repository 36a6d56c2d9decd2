// Room on the disk of a store that additions leave free: a change takes room in the log before it
// frees any, so what has filled its own disk could not be emptied; and how many bytes an addition
// brings. Not thread-safe but const.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "storage/records.h"
#include "storage/sqlite/connection.h"

namespace motiondb::core {
class Model;
}

namespace motiondb::storage {

class DiskReserve {
 public:
  // Keeps `bytes` free on the disk of the store at `path`; 0: does not look.
  DiskReserve(std::string path, std::int64_t bytes) : path_(std::move(path)), bytes_(bytes) {}

  bool is_off() const { return bytes_ == 0; }
  // Whether there is room for so many more bytes: in the log, then in the file, beyond what the log
  // holds already and what is to stay free. RESOURCE_EXHAUSTED, saying what there is and what has
  // to be. Empties the log where that may give room. REQUIRES: on the writer's thread, and `writer`
  // is in no transaction.
  absl::Status Check(Connection& writer, std::int64_t added_bytes) const;

  // Whether the disk has more room than the reserve: if not, every addition is refused. Looks at
  // the disk alone, so any thread may call it. True if that cannot be seen.
  bool IsLeft() const;
  // Whether there is room for so many more bytes of a file beside the store. RESOURCE_EXHAUSTED.
  absl::Status CheckBeside(std::int64_t added_bytes) const;

  // Empties the log where less is free than the reserve, so that what deletions take of that is
  // given back by the next one. REQUIRES: as above.
  void GiveBack(Connection& writer) const;

 private:
  struct Room {
    std::int64_t free = 0;   // bytes on the disk
    std::int64_t log = 0;    // bytes of the log, which are still to be moved into the file
    std::int64_t freed = 0;  // bytes of the file that nothing uses: additions take these first
  };
  absl::StatusOr<std::int64_t> FreeBytes() const;
  absl::StatusOr<Room> Look(Connection& writer) const;
  absl::Status Refuse(std::int64_t free, std::int64_t added_bytes) const;
  std::int64_t Needed(const Room& room, std::int64_t added_bytes) const;

  const std::string path_;
  const std::int64_t bytes_;
};

// A skeleton's own encoding and the record, some kilobytes, are not counted.
std::int64_t AddedBytes(const NewClip& clip);
// With the files, which are written again where they get other states.
std::int64_t AddedBytes(const DerivedClip& clip);
// Takes as long as copying them does.
std::int64_t AddedBytes(const core::Model& model);

}  // namespace motiondb::storage
