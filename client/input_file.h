// A file that is read from its beginning, in blocks or whole. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

class InputFile {
 public:
  // NOT_FOUND if there is none, INVALID_ARGUMENT for a folder, UNKNOWN where it cannot be opened;
  // all name it, and why.
  static absl::StatusOr<InputFile> Open(const std::filesystem::path& path);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;
  ~InputFile();

  // Puts the next bytes into `block`, `most` unless the file ends before; none at the end. UNKNOWN,
  // naming the file and why, where it cannot be read.
  absl::Status Read(std::size_t most, std::string& block);

  // Bytes of a regular file; nothing of a pipe or a device, whose end only reading finds.
  std::optional<std::uint64_t> size() const { return size_; }

 private:
  InputFile(std::filesystem::path path, int descriptor);

  std::filesystem::path path_;
  int descriptor_;
  std::optional<std::uint64_t> size_;
};

// All bytes of a file. As InputFile; and INVALID_ARGUMENT, naming it, where there are more than
// `most_bytes`: of a regular file none is read then, of a device without an end no more than that.
absl::StatusOr<std::string> ReadWholeFile(const std::filesystem::path& path,
                                          std::size_t most_bytes);

}  // namespace motiondb::client
