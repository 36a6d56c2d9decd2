#include "core/format/file_format.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr std::array<FormatInfo, 9> kFormats = {{
    {FileFormat::kBvh, "bvh", ".bvh", "Biovision hierarchy", "", true, false, true},
    {FileFormat::kAmc, "amc", ".amc", "Acclaim motion with its skeleton", ".asf", true, false,
     false},
    {FileFormat::kTrc, "trc", ".trc", "marker trajectories as text (OpenSim)", "", true, false,
     true},
    {FileFormat::kC3d, "c3d", ".c3d", "marker trajectories (c3d.org)", "", true, false, true},
    {FileFormat::kCsv, "csv", ".csv",
     "joints of a robot with its URDF (motiondb, LAFAN1 on G1, BONES-SEED), or a table of points",
     ".urdf", true, false, true},
    {FileFormat::kNpz, "npz", ".npz", "NumPy archives: AMASS, SMPL, SMPL-H, SMPL-X, motiondb", "",
     false, false, true},
    {FileFormat::kFbx, "fbx", ".fbx", "Autodesk FBX, binary and text", "", false, true, false},
    {FileFormat::kGltf, "gltf", ".gltf .glb .vrm", "glTF 2.0 in one file, VRM", "", false, true,
     true},
    {FileFormat::kCollada, "dae", ".dae", "Collada", "", false, true, false},
}};

constexpr std::string_view kGzipMagic = "\x1f\x8b";
constexpr std::string_view kGzipExtension = ".gz";

// Calls `visit` for each extension of a format.
template <typename Visit>
void ForEachExtension(const FormatInfo& info, const Visit& visit) {
  for (std::string_view rest = info.extensions; !rest.empty();) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    visit(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

std::string_view ExtensionOf(std::string_view path) {
  return path.substr(std::min(path.rfind('.'), path.size()));
}

}  // namespace

std::span<const FormatInfo> KnownFormats() { return kFormats; }

const FormatInfo& InfoOf(FileFormat format) { return kFormats[static_cast<std::size_t>(format)]; }

absl::StatusOr<FileFormat> FormatOfPath(std::string_view path) {
  std::string_view plain = path;
  if (IsKeyword(ExtensionOf(plain), kGzipExtension)) plain.remove_suffix(kGzipExtension.size());
  const FormatInfo* found = nullptr;
  std::string known;
  for (const FormatInfo& info : kFormats) {
    ForEachExtension(info, [&](std::string_view extension) {
      if (IsKeyword(ExtensionOf(plain), extension)) found = &info;
      known += (known.empty() ? "" : ", ") + std::string(extension);
    });
  }
  if (found != nullptr) return found->format;
  return InvalidArgument("{}: expected a motion file ({}, or one of these with .gz)", path, known);
}

std::string_view WrittenExtension(FileFormat format) {
  if (format == FileFormat::kGltf) return ".glb";
  const std::string_view extensions = InfoOf(format).extensions;
  return extensions.substr(0, extensions.find(' '));
}

bool NeedsImport(FileFormat format, std::string_view bytes) {
  return !InfoOf(format).is_read_here || bytes.starts_with(kGzipMagic);
}

}  // namespace motiondb::core
