// Bytes of a file, mapped into memory.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::importer {

class InputBytes {
 public:
  // NOT_FOUND, or INVALID_ARGUMENT for a folder or a file above `max_bytes`.
  static absl::StatusOr<InputBytes> Open(const std::string& path, std::size_t max_bytes);

  InputBytes() = default;
  InputBytes(InputBytes&& other) noexcept;
  InputBytes& operator=(InputBytes&& other) noexcept;
  ~InputBytes();

  std::string_view bytes() const { return {data_, size_}; }

 private:
  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace motiondb::importer
