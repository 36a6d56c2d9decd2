// A backup on disk. The file has no name until it is whole, so that two to one FILE do not mix. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "client/output_file.h"

struct evp_md_ctx_st;

namespace motiondb::client {

class BackupFile {
 public:
  BackupFile();
  BackupFile(const BackupFile&) = delete;
  BackupFile& operator=(const BackupFile&) = delete;
  ~BackupFile();  // removes what was not completed

  // ALREADY_EXISTS where there is a file, unless `overwrite`; then FAILED_PRECONDITION where what
  // is there is no backup, or a server has it as its store.
  absl::Status Open(const std::filesystem::path& path, bool overwrite);
  absl::Status Append(const std::string& block);
  // Brings it to the disk and gives it its name. DATA_LOSS unless its last 32 bytes are the SHA-256
  // of those before; ALREADY_EXISTS where there is a file by now, unless it may be overwritten, and
  // FAILED_PRECONDITION as above.
  // Where only the folder cannot be brought to the disk, that is said, and the backup is there.
  absl::Status Complete();

  std::int64_t bytes() const { return bytes_; }

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::filesystem::path path_;
  bool overwrite_ = false;
  std::optional<OutputFile> file_;  // between Open and Complete
  std::unique_ptr<evp_md_ctx_st, Free> digest_;
  std::string tail_;  // the last bytes so far, which may be the checksum
  std::int64_t bytes_ = 0;
};

// OK where there is nothing, or an empty file, or a backup that no server has as its store. Else
// FAILED_PRECONDITION, naming the path and what it is. What cannot be read is not replaced either.
absl::Status CheckReplaceable(const std::filesystem::path& path);

}  // namespace motiondb::client
