// The one way in which the client writes a file: into a new file without a name in the same folder,
// which gets its name when it is complete. A link is never followed: one that has the file's name
// is replaced. Where the file system or the system knows no files without names, the file is
// called `.motiondb-` and random digits until then. Not thread-safe.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

class OutputFile {
 public:
  // `mode` is that of the new file, less the process's umask. UNKNOWN if it cannot be made.
  static absl::StatusOr<OutputFile> Create(const std::filesystem::path& path, mode_t mode = 0666);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile();  // what has no name by then is gone

  absl::Status Append(std::string_view bytes);
  // Writes what Append kept back; with `to_disk` it survives a power cut, too.
  absl::Status Flush(bool to_disk = false);
  // Whether a regular file, not a link, of the final name has the same bytes as this one.
  absl::StatusOr<bool> IsThereAlready();
  // Flushes, and gives the file its name. Without `replace` ALREADY_EXISTS if anything has it, a
  // link among it; with it FAILED_PRECONDITION if that is neither a file nor a link.
  absl::Status Commit(bool replace);

 private:
  OutputFile(std::filesystem::path path, int descriptor, std::string temporary);
  absl::Status Failed() const;  // by errno
  absl::Status Name();
  absl::Status TakeFreeName();

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::string temporary_;  // the name until Commit; empty where it has none
  std::string kept_;       // not written yet
};

// OK for the name of a file that a server may choose: without folders, dots or dashes in front, and
// characters that a terminal acts on. Else DATA_LOSS.
absl::Status CheckFileNameFromServer(const std::string& name);

// A file that is written whole or not at all.

// Replaces what lies there. UNKNOWN, naming the file, if it cannot be written: then what lay there
// still does.
absl::Status WriteWholeFile(const std::filesystem::path& path, std::string_view bytes);

}  // namespace motiondb::client
