// A backup file that is being written. It gets its name when it is complete, so that two concurrent
// backups to one path do not mix.
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
  ~BackupFile();  // removes an incomplete file

  // ALREADY_EXISTS: `path` exists, without `overwrite`. FAILED_PRECONDITION: the existing file is
  // not a backup, or is the store of a server.
  absl::Status Open(const std::filesystem::path& path, bool overwrite);
  absl::Status Append(const std::string& block);
  // Syncs the file to disk and gives it its name. DATA_LOSS: its last 32 bytes are not the SHA-256
  // of the bytes before. ALREADY_EXISTS, FAILED_PRECONDITION: as Open. UNKNOWN: a write or sync
  // failed; if only the sync of the folder failed, the backup exists.
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
  std::string tail_;  // the last 32 bytes so far, possibly the checksum
  std::int64_t bytes_ = 0;
};

// Returns OK if `path` does not exist, or is an empty file or a backup that is not the store of a
// server. FAILED_PRECONDITION: anything else, or a file that cannot be read; the error names it.
absl::Status CheckReplaceable(const std::filesystem::path& path);

}  // namespace motiondb::client
