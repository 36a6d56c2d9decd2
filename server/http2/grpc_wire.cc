#include "server/http2/grpc_wire.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/message.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <charconv>
#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"

namespace motiondb::server {

namespace {

// As grpc-message has it: all but printable ASCII, and '%', as % and two hexadecimal digits.
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

// Without padding, as gRPC wants it.
std::string Base64(std::string_view bytes) {
  std::string text = absl::Base64Escape({bytes.data(), bytes.size()});
  while (!text.empty() && text.back() == '=') text.pop_back();
  return text;
}

}  // namespace

MessagePrefix PrefixOf(std::uint32_t length) {
  return {0, static_cast<std::uint8_t>(length >> 24), static_cast<std::uint8_t>(length >> 16),
          static_cast<std::uint8_t>(length >> 8), static_cast<std::uint8_t>(length)};
}

bool IsCompressed(const MessagePrefix& prefix) { return prefix[0] != 0; }

std::uint32_t LengthIn(const MessagePrefix& prefix) {
  return std::uint32_t{prefix[1]} << 24 | std::uint32_t{prefix[2]} << 16 |
         std::uint32_t{prefix[3]} << 8 | std::uint32_t{prefix[4]};
}

std::optional<std::chrono::nanoseconds> ParseTimeout(std::string_view text) {
  if (text.size() < 2 || text.size() > 9) return std::nullopt;
  std::int64_t count = 0;
  const char* const end = text.data() + text.size() - 1;
  const auto parsed = std::from_chars(text.data(), end, count);
  if (parsed.ec != std::errc() || parsed.ptr != end || count < 0) return std::nullopt;
  using namespace std::chrono;
  switch (text.back()) {
    case 'H':  // more than a year is as good as none, and would not fit
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

HeaderList TrailersOf(const grpc::Status& status) {
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

// What an allocation costs beyond its bytes, a pointer to it, and what a growing array has to
// spare.
constexpr std::int64_t kAllocation = 64;
constexpr std::int64_t kOfAnyMessage = 512;  // what it keeps of fields that are wrong or cut off
constexpr std::int64_t kUnknownByte = 32;    // of a group: it may hold many small fields
constexpr std::int64_t kScalar = 2 * sizeof(std::int64_t);  // arrays grow by doubling
constexpr int kDeepest = 100;                               // as protobuf itself allows

std::int64_t SizeIn(const Descriptor& type, CodedInputStream& input, int depth) {
  const auto* const prototype = MessageFactory::generated_factory()->GetPrototype(&type);
  std::int64_t size =
      prototype == nullptr ? 0 : static_cast<std::int64_t>(prototype->SpaceUsedLong());
  while (const std::uint32_t tag = input.ReadTag()) {
    const FieldDescriptor* const field = type.FindFieldByNumber(Wire::GetTagFieldNumber(tag));
    size += field == nullptr ? kAllocation : kScalar;
    if (Wire::GetTagWireType(tag) != Wire::WIRETYPE_LENGTH_DELIMITED) {
      const int before = input.CurrentPosition();
      const bool is_whole = Wire::SkipField(&input, tag);
      if (Wire::GetTagWireType(tag) == Wire::WIRETYPE_START_GROUP) {
        size += kUnknownByte * (input.CurrentPosition() - before);
      }
      if (!is_whole) return size;
      continue;
    }
    std::uint32_t length = 0;
    if (!input.ReadVarint32(&length)) return size;
    const std::int64_t left = std::max(0, input.BytesUntilLimit());
    const auto present = static_cast<int>(std::min<std::int64_t>(length, left));
    const bool is_known = field != nullptr;
    if (is_known && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && depth < kDeepest) {
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
  const std::int64_t size = kOfAnyMessage + SizeIn(type, input, 0);
  input.PopLimit(whole);
  return size;
}

}  // namespace motiondb::server
