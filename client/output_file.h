// A file that the client writes; all its files are written with this class. The bytes go to an
// unnamed file (O_TMPFILE) in the same folder, which gets its name when it is complete. If the file
// system has no unnamed files, the temporary name is `.motiondb-` and random digits. A symbolic
// link with the final name is replaced, never followed.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

class OutputFile {
 public:
  // `mode`: permissions of the file, reduced by the umask. UNKNOWN: the file cannot be created.
  static absl::StatusOr<OutputFile> Create(const std::filesystem::path& path, mode_t mode = 0666);
  // As Create, for a file that may replace an existing one. FAILED_PRECONDITION: the name is
  // neither free nor a regular file nor a symbolic link.
  static absl::StatusOr<OutputFile> CreateReplacing(const std::filesystem::path& path);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile();  // removes the file unless committed

  absl::Status Append(std::string_view bytes);
  // Writes the buffer; with `to_disk` also syncs the file.
  absl::Status Flush(bool to_disk = false);
  // Returns whether the final name is a regular file, not a link, with the same contents.
  absl::StatusOr<bool> HasSameContent();
  // Flushes and gives the file its name. ALREADY_EXISTS: the name exists, also as a link, without
  // `replace`. FAILED_PRECONDITION: with `replace`, the name is neither a regular file nor a link.
  absl::Status Commit(bool replace);

 private:
  OutputFile(std::filesystem::path path, int descriptor, std::string temporary);
  absl::Status WriteError() const;  // UNKNOWN with the text of errno
  absl::Status CheckReplaceable() const;
  absl::Status RenameReplacing();
  absl::Status RenameIfFree();

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::string temporary_;  // temporary name; empty if unnamed
  std::string buffer_;     // not written yet
};

// Checks a file name that a server sent. DATA_LOSS: it has a folder or a control character, or
// begins with '.' or '-'.
absl::Status CheckFileNameFromServer(const std::string& name);

// Checks that WriteFileAtomically can write files of these names, so that a long computation does
// not end with that error. Empty names are ignored. UNKNOWN or FAILED_PRECONDITION, with the file
// name.
absl::Status CheckCanWrite(const std::vector<std::filesystem::path>& paths);

// Writes a file atomically; replaces an existing one. UNKNOWN, with the file name: it cannot be
// written; the existing file is unchanged.
absl::Status WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace motiondb::client
