#include "storage/sqlite/disk_reserve.h"

#include <sys/statvfs.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/motion/error.h"
#include "storage/sqlite/store_file.h"

namespace motiondb::storage {
namespace {

std::string Mebibytes(std::int64_t bytes) {
  return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / (1 << 20));
}

}  // namespace

absl::StatusOr<std::int64_t> DiskReserve::FreeBytes() const {
  struct statvfs disk {};
  if (statvfs(path_.c_str(), &disk) != 0) {
    return absl::UnavailableError(
        fmt::format("cannot read the free disk space of '{}': {}", path_, std::strerror(errno)));
  }
  // f_bavail does not include blocks that are reserved for the superuser.
  return static_cast<std::int64_t>(disk.f_bavail * disk.f_frsize);
}

absl::StatusOr<DiskReserve::Room> DiskReserve::Look(Connection& writer) const {
  Room room;
  MOTIONDB_ASSIGN_OR_RETURN(room.free, FreeBytes());
  std::error_code error;
  const auto log = std::filesystem::file_size(LogPath(path_), error);
  if (!error) room.log = static_cast<std::int64_t>(log);
  MOTIONDB_ASSIGN_OR_RETURN(const auto pages, writer.QueryInteger("PRAGMA freelist_count"));
  MOTIONDB_ASSIGN_OR_RETURN(const auto page_bytes, writer.QueryInteger("PRAGMA page_size"));
  room.freed = pages * page_bytes;
  return room;
}

std::int64_t DiskReserve::Needed(const Room& room, std::int64_t added_bytes) const {
  const std::int64_t grows = std::max<std::int64_t>(added_bytes - room.freed, 0);
  return room.log + added_bytes + grows + bytes_;
}

absl::Status DiskReserve::Check(Connection& writer, std::int64_t added_bytes) const {
  if (is_off()) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(Room room, Look(writer));
  if (room.free < Needed(room, added_bytes) && room.log > 0) {
    CheckpointLog(writer);
    MOTIONDB_ASSIGN_OR_RETURN(room, Look(writer));
  }
  const std::int64_t needed = Needed(room, added_bytes);
  if (room.free >= needed) return absl::OkStatus();
  return Refuse(room.free, needed - bytes_);
}

absl::Status DiskReserve::CheckTemporaryFile(std::int64_t added_bytes) const {
  if (is_off()) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t free, FreeBytes());
  return free >= added_bytes + bytes_ ? absl::OkStatus() : Refuse(free, added_bytes);
}

absl::Status DiskReserve::Refuse(std::int64_t free, std::int64_t added_bytes) const {
  return core::WithReason(
      "DISK_FULL", absl::ResourceExhaustedError(fmt::format(
                       "{} free on the disk of '{}', expected {}: {} for the log and the new data, "
                       "and a reserve of "
                       "{} for deletions (--disk-reserve-mib); free disk space or delete clips",
                       Mebibytes(free), path_, Mebibytes(added_bytes + bytes_),
                       Mebibytes(added_bytes), Mebibytes(bytes_))));
}

bool DiskReserve::HasReserve() const {
  struct statvfs disk {};
  if (is_off() || statvfs(path_.c_str(), &disk) != 0) return true;
  return static_cast<std::int64_t>(disk.f_bavail * disk.f_frsize) > bytes_;
}

void DiskReserve::GiveBack(Connection& writer) const {
  if (is_off()) return;
  const auto room = Look(writer);
  if (room.ok() && room->free < bytes_ && room->log > 0) CheckpointLog(writer);
}

}  // namespace motiondb::storage
