// What every decoder of a blob promises: DATA_LOSS, or something that encodes to the same bytes.
#pragma once

#include <cstdint>
#include <span>

#include "storage/blob/byte_stream.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/properties.h"

namespace motiondb::tests {

// Room for an error's text, and how far a decoded thing may outgrow its bytes: an empty string of 4
// bytes lies in memory as 32.
inline constexpr std::size_t kDecodingBase = 64 << 10;
inline constexpr std::size_t kDecodingFactor = 24;

inline void HoldsSameBytes(const storage::StringSink& sink, std::span<const std::byte> bytes) {
  Holds(std::ranges::equal(std::as_bytes(std::span(sink.bytes())), bytes),
        "what was decoded encodes to the same bytes");
}

// decode(source) -> StatusOr<T>; encode(T, sink) -> Status. Returns what was decoded.
template <typename Decode, typename Encode>
auto HoldsCodec(std::span<const std::byte> bytes, const Decode& decode, const Encode& encode) {
  const MemoryWatch watch;
  storage::SpanSource source(bytes);
  auto decoded = decode(source);
  watch.HoldsProportional(bytes.size(), kDecodingBase, kDecodingFactor);
  HoldsError(decoded.status(), absl::StatusCode::kDataLoss);
  if (decoded.ok()) {
    storage::StringSink sink;
    Holds(encode(*decoded, sink).ok(), "what was decoded can be encoded");
    HoldsSameBytes(sink, bytes);
  }
  return decoded;
}

// The same of fields of a blob: get(reader) -> T, put(writer, T).
template <typename Get, typename Put>
auto HoldsFields(std::span<const std::byte> bytes, const Get& get, const Put& put) {
  using Value = decltype(get(std::declval<storage::FieldReader&>()));
  return HoldsCodec(
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
