// Reads a file from its beginning, in blocks or completely.
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
  // NOT_FOUND: the file does not exist. INVALID_ARGUMENT: it is a folder. UNKNOWN: it cannot be
  // opened. Errors name the file and the reason.
  static absl::StatusOr<InputFile> Open(const std::filesystem::path& path);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;
  ~InputFile();

  // Stores the next `max_bytes` bytes in `block`; fewer at the end of the file. UNKNOWN, with file
  // and reason: a read error.
  absl::Status Read(std::size_t max_bytes, std::string& block);

  // Size of a regular file in bytes; nullopt for a pipe or a device.
  std::optional<std::uint64_t> size() const { return size_; }

 private:
  InputFile(std::filesystem::path path, int descriptor);

  std::filesystem::path path_;
  int descriptor_;
  std::optional<std::uint64_t> size_;
};

// Returns all bytes of a file. Errors as InputFile, and INVALID_ARGUMENT if the file has more than
// `max_bytes`. It never reads more, also from a device without an end.
absl::StatusOr<std::string> ReadWholeFile(const std::filesystem::path& path, std::size_t max_bytes);

}  // namespace motiondb::client
