#include "core/inspection/draft_mapping.h"

#include <fmt/format.h>

#include <string_view>

#include "core/format/marker_set_tokens.h"

namespace motiondb::core {
namespace {

// The marker of standard34 that is at a role, without its side.
struct MarkerOfRole {
  const char* marker;
  Role role;
  bool has_sides;
};
constexpr MarkerOfRole kMarkers[] = {
    {"Hip", Role::kHip, true},          {"Knee", Role::kKnee, true},
    {"Ankle", Role::kAnkle, true},      {"Toe", Role::kToe, true},
    {"Waist", Role::kSpine, false},     {"Spine", Role::kSpine, false},
    {"Neck", Role::kNeck, false},       {"Head", Role::kHead, false},
    {"HeadTop", Role::kHeadTop, false}, {"Shoulder", Role::kShoulder, true},
    {"Elbow", Role::kElbow, true},      {"Wrist", Role::kWrist, true},
    {"Hand", Role::kHand, true}};

}  // namespace

std::string DraftMapping(const MarkerSet& set, const PointCloud& points, const std::string& name) {
  const Figure figure = FindFigure(points);
  std::string text =
      fmt::format("# A draft: complete the rules of all markers of {}.\nmapping {}\n", set.name,
                  QuotedName(name));
  for (const auto& [marker, role, has_sides] : kMarkers) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      if (!has_sides && side == Side::kRight) continue;
      const char* const letter = !has_sides ? "" : side == Side::kLeft ? "L" : "R";
      RolePoint point = figure.at(role, side);
      if (role == Role::kSpine && !figure.spine.empty()) {
        const std::size_t at = std::string_view(marker) == "Waist" ? 0 : figure.spine.size() / 2;
        point = {figure.spine[at], 1};
      }
      text += point.is_found()
                  ? fmt::format("{}{} = {}  # confidence {:.2f}\n", letter, marker,
                                QuotedName(figure.names[point.index]), point.confidence)
                  : fmt::format("# {}{} = ?\n", letter, marker);
    }
  }
  return text;
}

}  // namespace motiondb::core
