#include "storage/blob/byte_stream.h"

#include <algorithm>

#include "core/motion/error.h"

namespace motiondb::storage {

absl::Status StringSink::Write(std::span<const std::byte> bytes) {
  bytes_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return absl::OkStatus();
}

absl::Status SpanSource::Read(std::span<std::byte> out) {
  if (out.size() > bytes_.size()) {
    return core::DataLoss("expected {} more bytes, got {}", out.size(), bytes_.size());
  }
  std::copy_n(bytes_.begin(), out.size(), out.begin());
  bytes_ = bytes_.subspan(out.size());
  return absl::OkStatus();
}

absl::Status SpanSource::Finish() {
  if (!bytes_.empty()) return core::DataLoss("{} bytes are left over", bytes_.size());
  return absl::OkStatus();
}

}  // namespace motiondb::storage
