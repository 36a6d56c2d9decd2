// Byte streams between codecs and storage, and typed fields on them. One stream serves one
// encoding.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/motion/error.h"

namespace motiondb::storage {

class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual absl::Status Write(std::span<const std::byte> bytes) = 0;
};

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  // Fills `out`. DATA_LOSS if fewer bytes are left or the bytes are corrupt.
  virtual absl::Status Read(std::span<std::byte> out) = 0;
  // DATA_LOSS unless all bytes were read.
  virtual absl::Status Finish() = 0;
  // Returns the number of unread bytes, never more than exist: callers check sizes against it
  // before they allocate memory.
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

// Reads bytes in memory, which must outlive it.
class SpanSource final : public ByteSource {
 public:
  explicit SpanSource(std::span<const std::byte> bytes) : bytes_(bytes) {}
  absl::Status Read(std::span<std::byte> out) override;
  absl::Status Finish() override;
  std::uint64_t remaining() const override { return bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
};

// FieldWriter and FieldReader: a sequence of little-endian numbers, arrays and text on a stream.
// Both keep the first error and do nothing after it, so that a codec checks the status once, at the
// end.

static_assert(std::endian::native == std::endian::little && std::numeric_limits<float>::is_iec559,
              "numbers are stored in the memory layout of a little-endian machine");

// Types that are stored in their memory layout: numbers, and structs of integers without padding.
template <typename T>
concept Storable = (std::is_arithmetic_v<T> && !std::same_as<T, bool>) ||
                   (std::is_trivially_copyable_v<T> && std::has_unique_object_representations_v<T>);

class FieldWriter {
 public:
  // The sink must outlive the writer.
  explicit FieldWriter(ByteSink& sink) : sink_(sink) {}

  template <Storable T>
  void Put(T value) {
    PutElements(std::span<const T>(&value, 1));
  }

  // Writes the elements without their number.
  template <Storable T>
  void PutElements(std::span<const T> elements) {
    if (status_.ok()) status_ = sink_.Write(std::as_bytes(elements));
  }

  // The number of elements (u32), then the elements.
  template <Storable T>
  void PutArray(const std::vector<T>& elements) {
    PutCount(elements.size());
    PutElements(std::span<const T>(elements));
  }

  // The number of bytes (u32), then the bytes.
  void PutText(std::string_view text);

  // The number of items that follow (u32). INVALID_ARGUMENT if it exceeds 32 bits.
  void PutCount(std::size_t count);

  const absl::Status& status() const { return status_; }

 private:
  ByteSink& sink_;
  absl::Status status_;
};

class FieldReader {
 public:
  // The source must outlive the reader.
  explicit FieldReader(ByteSource& source) : source_(source) {}

  // The Get functions return 0, an empty array or an empty text after an error.
  template <Storable T>
  T Get() {
    T value{};
    GetElements(std::span(&value, 1));
    return value;
  }

  template <Storable T>
  void GetElements(std::span<T> elements) {
    if (status_.ok()) status_ = source_.Read(std::as_writable_bytes(elements));
  }

  template <Storable T>
  std::vector<T> GetArray() {
    std::vector<T> elements(GetCount(sizeof(T)));
    GetElements(std::span(elements));
    return elements;
  }

  std::string GetText();

  // Reads a number of items of at least `item_bytes` bytes each; an error if fewer bytes are left.
  std::size_t GetCount(std::size_t item_bytes);

  // Sets the error if there is none yet.
  void Fail(absl::Status status);

  bool ok() const { return status_.ok(); }
  // Returns the first error; DATA_LOSS if unread bytes are left.
  absl::Status Finish();
  const absl::Status& status() const { return status_; }
  std::uint64_t remaining() const { return source_.remaining(); }

 private:
  ByteSource& source_;
  absl::Status status_;
};

// Matrices of numbers without their size, which earlier fields contain.

template <typename Matrix>
void PutMatrix(FieldWriter& writer, const Matrix& matrix) {
  writer.PutElements(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

// Fails before it allocates memory if fewer than rows x columns floats are left.
template <typename Matrix>
void GetMatrix(FieldReader& reader, Eigen::Index rows, Eigen::Index columns, Matrix& matrix) {
  if (!reader.ok()) return;
  // Compares quotients: the product of two corrupt counts can overflow.
  const std::uint64_t numbers = reader.remaining() / sizeof(float);
  if (rows != 0 &&
      static_cast<std::uint64_t>(columns) > numbers / static_cast<std::uint64_t>(rows)) {
    return reader.Fail(core::DataLoss("expected {} x {} numbers, got {} bytes", rows, columns,
                                      reader.remaining()));
  }
  matrix.resize(rows, columns);
  reader.GetElements(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

}  // namespace motiondb::storage
