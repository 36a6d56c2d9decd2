#include "import/scene/gltf_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include "absl/strings/escaping.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::importer {

namespace {

constexpr std::size_t kGlbHeader = 12;
constexpr std::size_t kGlbChunkHeader = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

std::uint32_t Word(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

struct GlbChunks {
  std::string_view json;
  std::string_view binary;
};

absl::Status GlbTruncated(core::SourceFile file, std::string_view what, std::size_t end) {
  return core::InvalidArgument("{}: is truncated: its {} ends at byte {}, the file at byte {}",
                               file.name, what, end, file.bytes.size());
}

absl::StatusOr<GlbChunks> SplitGlb(core::SourceFile file) {
  const std::string_view bytes = file.bytes;
  if (bytes.size() < kGlbHeader) return GlbTruncated(file, "header", kGlbHeader);
  if (const std::uint32_t version = Word(bytes, 4); version != 2) {
    return core::InvalidArgument("{}: Unsupported binary glTF version {}: convert it to glTF 2.0",
                                 file.name, version);
  }
  GlbChunks chunks;
  for (std::size_t at = kGlbHeader; at < Word(bytes, 8);) {
    if (bytes.size() - at < kGlbChunkHeader) {
      return GlbTruncated(file, "chunk header", at + kGlbChunkHeader);
    }
    const std::size_t length = Word(bytes, at);
    const std::uint32_t type = Word(bytes, at + 4);
    at += kGlbChunkHeader;
    if (bytes.size() - at < length) {
      return GlbTruncated(file, type == kJsonChunk ? "JSON chunk" : "binary chunk", at + length);
    }
    if (type == kJsonChunk && chunks.json.empty()) chunks.json = bytes.substr(at, length);
    if (type == kBinaryChunk && chunks.binary.empty()) chunks.binary = bytes.substr(at, length);
    at += length;
  }
  if (!chunks.json.empty()) return chunks;
  return core::InvalidArgument("{}: expected a JSON chunk at byte {}", file.name, kGlbHeader);
}

absl::StatusOr<GltfJson> ParseGltfJson(core::SourceFile file, std::string_view text) {
  try {
    return GltfJson::parse(text);
  } catch (const GltfJson::parse_error& error) {
    const std::size_t in_text = std::min(error.byte == 0 ? 0 : error.byte - 1, text.size());
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(in_text), '\n');
    const auto byte = static_cast<std::size_t>(text.data() - file.bytes.data()) + in_text;
    return core::InvalidArgument("{}: {} at byte {} (line {} of its JSON)", file.name,
                                 in_text >= text.size() ? "is truncated" : "invalid JSON", byte,
                                 line);
  }
}

std::size_t WidthOf(std::string_view type) {
  constexpr std::pair<std::string_view, std::size_t> kWidths[] = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
  for (const auto& [name, width] : kWidths) {
    if (name == type) return width;
  }
  return 0;
}

template <typename Integer>
float IntegerAt(const char* bytes, bool is_normalized) {
  Integer value;
  std::memcpy(&value, bytes, sizeof(value));
  const auto number = static_cast<float>(value);
  if (!is_normalized) return number;
  return std::max(-1.0F, number / static_cast<float>(std::numeric_limits<Integer>::max()));
}

float NumberAt(const char* bytes, int component, bool is_normalized) {
  switch (component) {
    case kGltfByte:
      return IntegerAt<std::int8_t>(bytes, is_normalized);
    case kGltfUnsignedByte:
      return IntegerAt<std::uint8_t>(bytes, is_normalized);
    case kGltfShort:
      return IntegerAt<std::int16_t>(bytes, is_normalized);
    case kGltfUnsignedShort:
      return IntegerAt<std::uint16_t>(bytes, is_normalized);
    case kGltfUnsignedInt:
      return IntegerAt<std::uint32_t>(bytes, is_normalized);
    default: {
      float number = 0;
      std::memcpy(&number, bytes, sizeof(number));
      return number;
    }
  }
}

}  // namespace

std::size_t GltfComponentBytes(int component) {
  switch (component) {
    case kGltfByte:
    case kGltfUnsignedByte:
      return 1;
    case kGltfShort:
    case kGltfUnsignedShort:
      return 2;
    case kGltfUnsignedInt:
    case kGltfFloat:
      return 4;
    default:
      return 0;
  }
}

const GltfJson& GltfMember(const GltfJson& object, const char* member) {
  static const GltfJson kNone;
  if (!object.is_object()) return kNone;
  const auto found = object.find(member);
  return found == object.end() ? kNone : *found;
}

std::optional<std::size_t> GltfUnsigned(const GltfJson& object, const char* member) {
  constexpr std::size_t kMost = std::size_t{1} << 53;
  const GltfJson& value = GltfMember(object, member);
  if (!value.is_number_unsigned() || value.get<std::size_t>() > kMost) return std::nullopt;
  return value.get<std::size_t>();
}

absl::StatusOr<GltfDocument> GltfDocument::Parse(core::SourceFile file) {
  GltfDocument document(file);
  std::string_view text = file.bytes;
  if (text.starts_with("glTF")) {
    MOTIONDB_ASSIGN_OR_RETURN(const GlbChunks chunks, SplitGlb(file));
    text = chunks.json;
    document.binary_ = chunks.binary;
  }
  MOTIONDB_ASSIGN_OR_RETURN(document.json_, ParseGltfJson(file, text));
  const GltfJson& version = GltfMember(GltfMember(document.json_, "asset"), "version");
  if (!version.is_string() || !version.get_ref<const std::string&>().starts_with("2")) {
    return core::InvalidArgument("{}: Unsupported glTF version {}: convert it to glTF 2.0",
                                 file.name, core::Shown(version.dump()));
  }
  return document;
}

const GltfJson* GltfDocument::Find(const char* array, const GltfJson& index) const {
  const GltfJson& all = GltfMember(json_, array);
  if (!all.is_array() || !index.is_number_unsigned()) return nullptr;
  const auto i = index.get<std::size_t>();
  return i < all.size() ? &all[i] : nullptr;
}

absl::StatusOr<GltfAccessor> GltfDocument::Accessor(const GltfJson& index) const {
  const GltfJson* const found = Find("accessors", index);
  GltfAccessor accessor{.json = found,
                        .path = fmt::format("accessors[{}]", core::Shown(index.dump()))};
  if (found == nullptr) {
    return core::InvalidArgument("{}: {}: there is no such accessor", file_.name, accessor.path);
  }
  const auto expected = [&](std::string_view member, std::string_view what, const GltfJson& value) {
    return core::InvalidArgument("{}: {}.{}: expected {}, found {}", file_.name, accessor.path,
                                 member, what, core::Shown(value.dump()));
  };
  const auto component = GltfUnsigned(*found, "componentType").value_or(0);
  if (component > kGltfFloat || GltfComponentBytes(static_cast<int>(component)) == 0) {
    return expected("componentType", "5120 to 5123, 5125 or 5126",
                    GltfMember(*found, "componentType"));
  }
  accessor.component = static_cast<int>(component);
  const auto count = GltfUnsigned(*found, "count");
  if (!count) return expected("count", "a number from 0", GltfMember(*found, "count"));
  accessor.count = *count;
  const GltfJson& type = GltfMember(*found, "type");
  const std::string name = type.is_string() ? type.get<std::string>() : "";
  accessor.width = WidthOf(name);
  if (accessor.width == 0 && name != "MAT2" && name != "MAT3" && name != "MAT4") {
    return expected("type", "SCALAR, VEC2 to VEC4 or MAT2 to MAT4", type);
  }
  return accessor;
}

absl::StatusOr<std::string_view> GltfDocument::Buffer(const GltfJson& index,
                                                      std::string& storage) const {
  constexpr std::string_view kBase64 = ";base64,";
  constexpr std::size_t kLongestType = 200;
  const GltfJson* const buffer = Find("buffers", index);
  if (buffer == nullptr) return core::InvalidArgument("there is no such buffer");
  const GltfJson& uri = GltfMember(*buffer, "uri");
  if (!uri.is_string()) return binary_;
  const std::string_view text = uri.get_ref<const std::string&>();
  const std::size_t mark = text.substr(0, kLongestType).find(kBase64);
  const std::string_view digits = mark == text.npos ? "" : text.substr(mark + kBase64.size());
  if (!text.starts_with("data:") || mark == text.npos ||
      !absl::Base64Unescape({digits.data(), digits.size()}, &storage)) {
    return core::InvalidArgument("its buffer is not embedded in base64");
  }
  return storage;
}

absl::StatusOr<std::vector<float>> GltfDocument::Numbers(const GltfAccessor& accessor) const {
  const auto failure = [&](std::string_view what) {
    return core::InvalidArgument("{}: {}: {}", file_.name, accessor.path, what);
  };
  const GltfJson& json = *accessor.json;
  const GltfJson* const view = Find("bufferViews", GltfMember(json, "bufferView"));
  if (json.contains("sparse") || view == nullptr) {
    return failure("sparse keys are not read: export them in full");
  }
  std::string storage;
  const auto buffer = Buffer(GltfMember(*view, "buffer"), storage);
  if (!buffer.ok()) return failure(std::string(buffer.status().message()));
  const std::size_t bytes = GltfComponentBytes(accessor.component);
  const std::size_t element = bytes * accessor.width;
  const std::size_t stride = GltfUnsigned(*view, "byteStride").value_or(element);
  const std::size_t begin =
      GltfUnsigned(*view, "byteOffset").value_or(0) + GltfUnsigned(json, "byteOffset").value_or(0);
  const bool fits =
      accessor.width > 0 && stride >= element && stride <= 252 + element &&
      begin <= buffer->size() &&
      accessor.count <= buffer->size() / std::max<std::size_t>(1, stride) + 1 &&
      (accessor.count == 0 || begin + (accessor.count - 1) * stride + element <= buffer->size());
  if (!fits) {
    return failure(fmt::format("expected {} elements from byte {} of its buffer of {} bytes",
                               accessor.count, begin, buffer->size()));
  }
  const GltfJson& flag = GltfMember(json, "normalized");
  const bool is_normalized = flag.is_boolean() && flag.get<bool>();
  std::vector<float> numbers;
  numbers.reserve(accessor.count * accessor.width);
  for (std::size_t i = 0; i < accessor.count; ++i) {
    for (std::size_t k = 0; k < accessor.width; ++k) {
      numbers.push_back(NumberAt(buffer->data() + begin + i * stride + k * bytes,
                                 accessor.component, is_normalized));
      if (std::isfinite(numbers.back())) continue;
      return failure(fmt::format("element {}: expected a finite number", i));
    }
  }
  return numbers;
}

}  // namespace motiondb::importer
