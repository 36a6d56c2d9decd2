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
  if (!bytes_.empty()) return core::DataLoss("{} unexpected bytes at the end", bytes_.size());
  return absl::OkStatus();
}

void FieldWriter::PutText(std::string_view text) {
  PutCount(text.size());
  PutElements(std::span(text.data(), text.size()));
}

void FieldWriter::PutCount(std::size_t count) {
  if (status_.ok() && count > std::numeric_limits<std::uint32_t>::max()) {
    status_ =
        core::InvalidArgument("too many items to store: expected fewer than 2^32, got {}", count);
  }
  Put(static_cast<std::uint32_t>(count));
}

std::string FieldReader::GetText() {
  std::string text(GetCount(1), '\0');
  GetElements(std::span(text));
  return text;
}

std::size_t FieldReader::GetCount(std::size_t item_bytes) {
  const auto count = Get<std::uint32_t>();
  if (!ok()) return 0;
  if (count > remaining() / item_bytes) {
    Fail(core::DataLoss("expected {} items of {} bytes or more, got {} bytes", count, item_bytes,
                        remaining()));
    return 0;
  }
  return count;
}

void FieldReader::Fail(absl::Status status) {
  if (ok()) status_ = std::move(status);
}

absl::Status FieldReader::Finish() {
  if (ok()) status_ = source_.Finish();
  return status_;
}

}  // namespace motiondb::storage
