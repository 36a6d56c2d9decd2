#include "server/http2/grpc_wire.h"

#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/message.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <charconv>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"

namespace motiondb::server {
namespace {

// Percent-encodes '%' and everything but printable ASCII, as grpc-message requires.
std::string PercentEncoded(std::string_view text) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    if (absl::ascii_isprint(static_cast<unsigned char>(c)) && c != '%') {
      encoded += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    encoded += {'%', kDigits[byte >> 4], kDigits[byte & 0xf]};
  }
  return encoded;
}

// Without padding, as gRPC requires.
std::string Base64(std::string_view bytes) {
  std::string text = absl::Base64Escape({bytes.data(), bytes.size()});
  while (!text.empty() && text.back() == '=') text.pop_back();
  return text;
}

}  // namespace

std::optional<std::chrono::nanoseconds> ParseTimeout(std::string_view text) {
  if (text.size() < 2 || text.size() > 9) return std::nullopt;
  std::int64_t count = 0;
  const char* const end = text.data() + text.size() - 1;
  const auto parsed = std::from_chars(text.data(), end, count);
  if (parsed.ec != std::errc() || parsed.ptr != end || count < 0) return std::nullopt;
  using namespace std::chrono;
  switch (text.back()) {
    case 'H':  // clamped to about a year: more would overflow
      return hours(std::min<std::int64_t>(count, 24 * 366));
    case 'M':
      return minutes(std::min<std::int64_t>(count, 60 * 24 * 366));
    case 'S':
      return seconds(count);
    case 'm':
      return milliseconds(count);
    case 'u':
      return microseconds(count);
    case 'n':
      return nanoseconds(count);
    default:
      return std::nullopt;
  }
}

HeaderList MakeTrailers(const grpc::Status& status) {
  HeaderList trailers = {{"grpc-status", std::to_string(static_cast<int>(status.error_code()))}};
  if (!status.error_message().empty()) {
    trailers.emplace_back("grpc-message", PercentEncoded(status.error_message()));
  }
  if (!status.error_details().empty()) {
    trailers.emplace_back("grpc-status-details-bin", Base64(status.error_details()));
  }
  return trailers;
}

std::string PrintableAscii(std::string_view text) {
  std::string printable(text);
  std::ranges::replace_if(
      printable, [](unsigned char c) { return !absl::ascii_isprint(c); }, '?');
  return printable;
}

namespace {

using google::protobuf::Descriptor;
using google::protobuf::DescriptorPool;
using google::protobuf::FieldDescriptor;
using google::protobuf::MessageFactory;
using google::protobuf::io::CodedInputStream;
using Wire = google::protobuf::internal::WireFormatLite;

// Costs in bytes. An allocation: its overhead, a pointer to it, and spare capacity of arrays.
constexpr std::int64_t kAllocation = 64;
constexpr std::int64_t kMapEntry = 256;                     // a node, its key and its value
constexpr std::int64_t kMessageBase = 512;                  // for invalid and truncated fields
constexpr std::int64_t kUnknownGroupByte = 32;              // a group may have many small fields
constexpr std::int64_t kScalar = 2 * sizeof(std::int64_t);  // arrays grow by doubling
constexpr int kMaxDepth = 100;                              // protobuf's own limit

std::int64_t SizeOfEmpty(const Descriptor& type) {
  // A prototype of an entry has no value, so its size is unknown.
  if (type.options().map_entry()) return kMapEntry;
  const auto* const prototype = MessageFactory::generated_factory()->GetPrototype(&type);
  return prototype == nullptr ? 0 : static_cast<std::int64_t>(prototype->SpaceUsedLong());
}

std::int64_t SizeIn(const Descriptor& type, CodedInputStream& input, int depth) {
  std::int64_t size = SizeOfEmpty(type);
  while (const std::uint32_t tag = input.ReadTag()) {
    const FieldDescriptor* const field = type.FindFieldByNumber(Wire::GetTagFieldNumber(tag));
    size += field == nullptr ? kAllocation : kScalar;
    if (Wire::GetTagWireType(tag) != Wire::WIRETYPE_LENGTH_DELIMITED) {
      const int before = input.CurrentPosition();
      const bool is_whole = Wire::SkipField(&input, tag);
      if (Wire::GetTagWireType(tag) == Wire::WIRETYPE_START_GROUP) {
        size += kUnknownGroupByte * (input.CurrentPosition() - before);
      }
      if (!is_whole) return size;
      continue;
    }
    std::uint32_t length = 0;
    if (!input.ReadVarint32(&length)) return size;
    const std::int64_t available = std::max(0, input.BytesUntilLimit());
    const auto present = static_cast<int>(std::min<std::int64_t>(length, available));
    const bool is_known = field != nullptr;
    if (is_known && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && depth < kMaxDepth) {
      const CodedInputStream::Limit outer = input.PushLimit(present);
      size += kAllocation + SizeIn(*field->message_type(), input, depth + 1);
      input.Skip(std::max(0, input.BytesUntilLimit()));
      input.PopLimit(outer);
      continue;
    }
    // A packed number takes at least a byte.
    const bool is_packed = is_known && field->cpp_type() != FieldDescriptor::CPPTYPE_STRING;
    size += kAllocation + (is_packed ? kScalar * present : present);
    if (!input.Skip(present)) return size;
  }
  return size;
}

}  // namespace

const google::protobuf::MethodDescriptor* FindRpc(std::string_view path) {
  std::string name(path.substr(std::min<std::size_t>(1, path.size())));
  std::ranges::replace(name, '/', '.');
  return DescriptorPool::generated_pool()->FindMethodByName(name);
}

std::int64_t ParsedSize(const Descriptor& type, std::span<const std::uint8_t> bytes) {
  CodedInputStream input(bytes.data(), static_cast<int>(bytes.size()));
  const CodedInputStream::Limit whole = input.PushLimit(static_cast<int>(bytes.size()));
  const std::int64_t size = kMessageBase + SizeIn(type, input, 0);
  input.PopLimit(whole);
  return size;
}

}  // namespace motiondb::server
