// Typed fields on a byte stream: little-endian numbers, arrays and text, one after the other.
//
// Both classes keep the first error and do nothing after it, so that a codec reads as the list of
// its fields and asks once, at the end. Not thread-safe.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

static_assert(std::endian::native == std::endian::little && std::numeric_limits<float>::is_iec559,
              "numbers are stored as they lie in the memory of a little-endian machine");

// What is stored as it lies in memory: numbers, and structs of integers without padding.
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

  // Elements alone: their number is known from elsewhere.
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

  // How many items follow (u32). INVALID_ARGUMENT if there are more than that can say.
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

  // 0 after an error, as below: an empty array, an empty text.
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

  // A number of items, each of at least `item_bytes` bytes; an error if so many cannot follow.
  std::size_t GetCount(std::size_t item_bytes);

  // Makes `status` the error, if there is none yet.
  void Fail(absl::Status status);

  bool ok() const { return status_.ok(); }
  // DATA_LOSS unless all was read and every field was right.
  absl::Status Finish();
  const absl::Status& status() const { return status_; }
  std::uint64_t remaining() const { return source_.remaining(); }

 private:
  ByteSource& source_;
  absl::Status status_;
};

}  // namespace motiondb::storage
