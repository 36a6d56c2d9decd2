// The contract of every decoder of a blob: DATA_LOSS, or a value that encodes to the same bytes.
#pragma once

#include <cstdint>
#include <span>

#include "storage/blob/byte_stream.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/properties.h"

namespace motiondb::tests {

// Memory limits: room for an error's text, and the growth of a decoded value over its bytes. An
// empty string has 4 bytes encoded and 32 in memory.
inline constexpr std::size_t kDecodingBase = 64 << 10;
inline constexpr std::size_t kDecodingFactor = 24;

inline void CheckSameBytes(const storage::StringSink& sink, std::span<const std::byte> bytes) {
  CheckContract(std::ranges::equal(std::as_bytes(std::span(sink.bytes())), bytes),
                "a decoded value encodes to the same bytes");
}

// decode(source) -> StatusOr<T>; encode(T, sink) -> Status. Returns the result of decode.
template <typename Decode, typename Encode>
auto CheckCodec(std::span<const std::byte> bytes, const Decode& decode, const Encode& encode) {
  const MemoryWatch watch;
  storage::SpanSource source(bytes);
  auto decoded = decode(source);
  watch.CheckProportional(bytes.size(), kDecodingBase, kDecodingFactor);
  CheckErrorContract(decoded.status(), absl::StatusCode::kDataLoss);
  if (decoded.ok()) {
    storage::StringSink sink;
    CheckContract(encode(*decoded, sink).ok(), "a decoded value can be encoded");
    CheckSameBytes(sink, bytes);
  }
  return decoded;
}

// CheckCodec for fields of a blob: get(reader) -> T, put(writer, T).
template <typename Get, typename Put>
auto CheckFieldCodec(std::span<const std::byte> bytes, const Get& get, const Put& put) {
  using Value = decltype(get(std::declval<storage::FieldReader&>()));
  return CheckCodec(
      bytes,
      [&](storage::ByteSource& source) -> absl::StatusOr<Value> {
        storage::FieldReader reader(source);
        Value value = get(reader);
        MOTIONDB_RETURN_IF_ERROR(reader.Finish());
        return value;
      },
      [&](const Value& value, storage::ByteSink& sink) {
        storage::FieldWriter writer(sink);
        put(writer, value);
        return writer.status();
      });
}

}  // namespace motiondb::tests
