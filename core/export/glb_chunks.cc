#include "core/export/glb_chunks.h"

#include <utility>

#include "core/export/little_endian.h"

namespace motiondb::core {
namespace {

constexpr std::size_t kGlbMagic = 0x46546C67;  // "glTF"
constexpr std::size_t kGlbVersion = 2;
constexpr std::size_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr std::size_t kBufferChunk = 0x004E4942;  // "BIN"
constexpr std::size_t kFileHeader = 12;           // bytes
constexpr std::size_t kChunkHeader = 8;

// Chunks start at multiples of 4 bytes.
std::size_t Aligned(std::size_t size) { return (size + 3) / 4 * 4; }

}  // namespace

void GlbLayout::AddView(std::size_t bytes, GlbTarget target) {
  nlohmann::ordered_json view = {{"buffer", 0}, {"byteOffset", size_}, {"byteLength", bytes}};
  if (target != GlbTarget::kNone) view["target"] = static_cast<int>(target);
  views_.push_back(std::move(view));
  offset_ = 0;
  size_ += bytes;
}

std::size_t GlbLayout::AddAccessor(std::string_view type, GlbComponent component, std::size_t count,
                                   std::size_t bytes) {
  accessors_.push_back({{"bufferView", views_.size() - 1},
                        {"byteOffset", offset_},
                        {"componentType", static_cast<int>(component)},
                        {"count", count},
                        {"type", type}});
  offset_ += count * bytes;
  return accessors_.size() - 1;
}

void GlbLayout::SetBounds(std::size_t accessor, nlohmann::ordered_json least,
                          nlohmann::ordered_json most) {
  accessors_[accessor]["min"] = std::move(least);
  accessors_[accessor]["max"] = std::move(most);
}

void GlbLayout::MoveTo(nlohmann::ordered_json& document) {
  document["accessors"] = std::move(accessors_);
  document["bufferViews"] = std::move(views_);
  document["buffers"] = nlohmann::ordered_json::array({{{"byteLength", size_}}});
}

std::size_t GlbSize(std::string_view json, const GlbLayout& layout) {
  return kFileHeader + 2 * kChunkHeader + Aligned(json.size()) + layout.size();
}

std::string BeginGlb(std::string_view json, const GlbLayout& layout) {
  std::string bytes;
  bytes.reserve(GlbSize(json, layout));
  const auto append = [&](std::size_t word) {
    AppendWord32(static_cast<std::uint32_t>(word), bytes);
  };
  append(kGlbMagic);
  append(kGlbVersion);
  append(GlbSize(json, layout));
  append(Aligned(json.size()));
  append(kJsonChunk);
  bytes += json;
  bytes.append(Aligned(json.size()) - json.size(), ' ');
  append(layout.size());
  append(kBufferChunk);
  return bytes;
}

}  // namespace motiondb::core
