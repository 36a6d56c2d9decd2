#include "client/cli/file_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "text/utf8.h"

namespace motiondb::client {
namespace {

struct KnownFormat {
  std::string_view extension;
  std::string_view name;  // in requests of motiondb-import
  v1::FileFormat format;
  bool is_written;
};

constexpr std::array<KnownFormat, 11> kFormats = {{
    {".bvh", "bvh", v1::FILE_FORMAT_BVH, true},
    {".amc", "amc", v1::FILE_FORMAT_AMC, false},
    {".trc", "trc", v1::FILE_FORMAT_TRC, true},
    {".c3d", "c3d", v1::FILE_FORMAT_C3D, true},
    {".csv", "csv", v1::FILE_FORMAT_CSV, true},
    {".npz", "npz", v1::FILE_FORMAT_NPZ, true},
    {".glb", "gltf", v1::FILE_FORMAT_GLTF, true},
    {".gltf", "gltf", v1::FILE_FORMAT_GLTF, false},
    {".vrm", "gltf", v1::FILE_FORMAT_GLTF, false},
    {".fbx", "fbx", v1::FILE_FORMAT_FBX, false},
    {".dae", "dae", v1::FILE_FORMAT_COLLADA, false},
}};

}  // namespace

std::string MotionExtension(const std::filesystem::path& file) {
  const std::string extension = text::LowerCase(file.extension().string());
  return extension == ".gz" ? text::LowerCase(file.stem().extension().string()) : extension;
}

bool IsMotionFile(const std::filesystem::path& file) {
  return std::ranges::find(kFormats, MotionExtension(file), &KnownFormat::extension) !=
         kFormats.end();
}

std::string MotionExtensions() {
  std::string text;
  for (const KnownFormat& known : kFormats) {
    text += (text.empty() ? "" : ", ") + std::string(known.extension);
  }
  return text;
}

absl::StatusOr<v1::FileFormat> WrittenFormat(const std::string& name) {
  const std::string extension = (name.starts_with('.') ? "" : ".") + text::LowerCase(name);
  const auto* const found = std::ranges::find(kFormats, extension, &KnownFormat::extension);
  if (found != kFormats.end() && found->is_written) return found->format;
  return absl::InvalidArgumentError(
      fmt::format("'{}' is no format that is written; expected {}", name, WrittenFormatNames()));
}

std::string NameOfFormat(v1::FileFormat format) {
  const auto* const found = std::ranges::find(kFormats, format, &KnownFormat::format);
  return found == kFormats.end() ? "" : std::string(found->name);
}

std::string WrittenFormatNames() {
  std::string text;
  for (const KnownFormat& known : kFormats) {
    if (known.is_written)
      text += (text.empty() ? "" : "|") + std::string(known.extension.substr(1));
  }
  return text;
}

}  // namespace motiondb::client
