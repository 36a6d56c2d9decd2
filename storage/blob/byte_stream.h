// Where encoded bytes go to and come from: the seam between codecs and what keeps the bytes. Not
// thread-safe; one stream serves one encoding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "absl/status/status.h"

namespace motiondb::storage {

class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual absl::Status Write(std::span<const std::byte> bytes) = 0;
};

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  // Fills `out`. DATA_LOSS if fewer bytes are left or they are damaged.
  virtual absl::Status Read(std::span<std::byte> out) = 0;
  // DATA_LOSS unless all bytes were read.
  virtual absl::Status Finish() = 0;
  // Bytes not yet read. No more than there are: sizes are checked against it before memory is
  // taken.
  virtual std::uint64_t remaining() const = 0;
};

// Appends to a string.
class StringSink final : public ByteSink {
 public:
  absl::Status Write(std::span<const std::byte> bytes) override;
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// Reads bytes that its owner keeps alive.
class SpanSource final : public ByteSource {
 public:
  explicit SpanSource(std::span<const std::byte> bytes) : bytes_(bytes) {}
  absl::Status Read(std::span<std::byte> out) override;
  absl::Status Finish() override;
  std::uint64_t remaining() const override { return bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace motiondb::storage
