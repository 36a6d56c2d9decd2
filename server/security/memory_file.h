// A file in memory that can be opened by its path and replaced as a whole. Not thread-safe, but
// whoever opens the path meanwhile gets either the old contents or the new.
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace motiondb::server {

class MemoryFile {
 public:
  // INTERNAL where the system gives none.
  static absl::StatusOr<MemoryFile> Make(const std::string& contents);
  MemoryFile(MemoryFile&& other) noexcept;
  MemoryFile& operator=(MemoryFile&&) = delete;
  ~MemoryFile();

  std::string path() const;
  absl::Status Replace(const std::string& contents);

 private:
  explicit MemoryFile(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

}  // namespace motiondb::server
