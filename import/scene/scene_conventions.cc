#include "import/scene/scene_conventions.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "import/scene/scene_nodes.h"

namespace motiondb::importer {

namespace {

constexpr double kCentimetre_m = 0.01;

bool IsUnit(double metres) { return metres > 1e-9 && metres < 1e9; }

// Returns a number of the scene's metadata.
std::optional<double> MetadataNumber(const aiScene& scene, std::string_view key) {
  if (scene.mMetaData == nullptr) return std::nullopt;
  for (unsigned i = 0; i < scene.mMetaData->mNumProperties; ++i) {
    if (NameView(scene.mMetaData->mKeys[i]) != key) continue;
    const aiMetadataEntry& entry = scene.mMetaData->mValues[i];
    if (entry.mData == nullptr) return std::nullopt;
    switch (entry.mType) {
      case AI_INT32:
        return *static_cast<const std::int32_t*>(entry.mData);
      case AI_FLOAT:
        return *static_cast<const float*>(entry.mData);
      case AI_DOUBLE:
        return *static_cast<const double*>(entry.mData);
      default:
        return std::nullopt;
    }
  }
  return std::nullopt;
}

StatedConventions StatedByFbx(const aiScene& scene, std::vector<std::string>& notes) {
  StatedConventions stated;
  if (const auto factor = MetadataNumber(scene, "UnitScaleFactor")) {
    if (IsUnit(*factor * kCentimetre_m)) {
      stated.metres_per_unit = *factor * kCentimetre_m;
    } else {
      notes.push_back(fmt::format("UnitScaleFactor {} is no unit", *factor));
    }
  }
  constexpr std::array<core::UpAxis, 3> kPlus = {core::UpAxis::kX, core::UpAxis::kY,
                                                 core::UpAxis::kZ};
  constexpr std::array<core::UpAxis, 3> kMinus = {core::UpAxis::kMinusX, core::UpAxis::kMinusY,
                                                  core::UpAxis::kMinusZ};
  const auto axis = MetadataNumber(scene, "UpAxis");
  const bool is_minus = MetadataNumber(scene, "UpAxisSign").value_or(1) < 0;
  if (axis == 0 || axis == 1 || axis == 2) {
    const auto index = static_cast<std::size_t>(*axis);
    stated.up_axis = is_minus ? kMinus[index] : kPlus[index];
  }
  // Time mode 0 states no rate; assimp then counts in seconds.
  const bool has_rate = MetadataNumber(scene, "FrameRate").value_or(0) != 0;
  if (has_rate && scene.mNumAnimations > 0) {
    const double rate_hz = scene.mAnimations[0]->mTicksPerSecond;
    if (core::IsFrameRate(rate_hz)) stated.frame_rate_hz = rate_hz;
  }
  return stated;
}

std::string WithoutXmlComments(std::string_view text) {
  std::string kept;
  while (!text.empty()) {
    const std::size_t comment = text.find("<!--");
    kept += text.substr(0, comment);
    if (comment == text.npos) break;
    const std::size_t end = text.find("-->", comment + 4);
    if (end == text.npos) break;
    text.remove_prefix(end + 3);
  }
  return kept;
}

// Returns the content of the file's first <asset>, which is that of the whole file.
std::string AssetText(std::string_view bytes) {
  const std::size_t begin = bytes.find("<asset");
  if (begin == bytes.npos) return "";
  const std::size_t end = bytes.find("</asset", begin);
  return end == bytes.npos ? "" : WithoutXmlComments(bytes.substr(begin, end - begin));
}

std::string_view ElementText(std::string_view xml, std::string_view start_tag) {
  std::size_t begin = xml.find(start_tag);
  if (begin == xml.npos) return {};
  begin += start_tag.size();
  return xml.substr(begin, xml.find('<', begin) - begin);
}

// Returns the attribute `meter` of <unit>; nothing if it is missing or not a number above 0.
std::optional<double> UnitOf(std::string_view asset) {
  constexpr std::string_view kMeter = "meter=";
  const std::size_t unit = asset.find("<unit");
  if (unit == asset.npos) return std::nullopt;
  const std::string_view tag = asset.substr(unit, asset.find('>', unit) - unit);
  const std::size_t meter = tag.find(kMeter);
  if (meter == tag.npos || meter + kMeter.size() >= tag.size()) return std::nullopt;
  const char quote = tag[meter + kMeter.size()];
  const std::string_view value = tag.substr(meter + kMeter.size() + 1);
  const auto number = core::ParseNumber(value.substr(0, value.find(quote)));
  return number && IsUnit(*number) ? number : std::nullopt;
}

absl::StatusOr<StatedConventions> StatedByCollada(core::SourceFile file, const aiScene& scene,
                                                  std::vector<std::string>& notes) {
  StatedConventions stated;
  const std::string asset = AssetText(file.bytes);
  const std::string_view up = ElementText(asset, "<up_axis>");
  if (up.find("X_UP") != up.npos) stated.up_axis = core::UpAxis::kX;
  if (up.find("Y_UP") != up.npos) stated.up_axis = core::UpAxis::kY;
  if (up.find("Z_UP") != up.npos) stated.up_axis = core::UpAxis::kZ;
  // The root is the visual scene, whose only transform is the unit.
  const double scale = std::cbrt(ToAffine(scene.mRootNode->mTransformation).linear().determinant());
  if (!IsUnit(std::abs(scale))) {
    return core::InvalidArgument("{}: expected a unit above 0 m, found {} m", file.name, scale);
  }
  stated.scene_units_per_unit = scale;
  const std::optional<double> unit = UnitOf(asset);
  constexpr double kSameUnit = 1e-3;
  if (unit && std::abs(*unit - scale) <= kSameUnit * scale) {
    stated.metres_per_unit = unit;
  } else if (asset.find("<unit") != asset.npos) {
    notes.push_back("its unit is not stated as a number above 0");
  }
  return stated;
}

}  // namespace

absl::StatusOr<StatedConventions> FindStatedConventions(core::FileFormat format,
                                                        core::SourceFile file, const aiScene& scene,
                                                        std::vector<std::string>& notes) {
  switch (format) {
    case core::FileFormat::kFbx:
      return StatedByFbx(scene, notes);
    case core::FileFormat::kCollada:
      return StatedByCollada(file, scene, notes);
    default:
      return StatedConventions{.metres_per_unit = 1, .up_axis = core::UpAxis::kY};
  }
}

}  // namespace motiondb::importer
