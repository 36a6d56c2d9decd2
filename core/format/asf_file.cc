#include "core/format/asf_file.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "core/format/gunzip.h"
#include "core/format/motion_file.h"
#include "core/format/text_scanner.h"

namespace motiondb::core {
namespace {

enum class Section { kNone, kUnits, kRoot, kBones, kHierarchy, kOther };

Section SectionOf(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, Section>, 4> kSections = {{
      {":units", Section::kUnits},
      {":root", Section::kRoot},
      {":bonedata", Section::kBones},
      {":hierarchy", Section::kHierarchy},
  }};
  for (const auto& [name, section] : kSections) {
    if (IsKeyword(word, name)) return section;
  }
  return Section::kOther;
}

std::optional<int> AxisOf(char c) {
  const std::string_view axes = "xyzXYZ";
  const auto at = axes.find(c);
  if (at == axes.npos) return std::nullopt;
  return static_cast<int>(at % 3);
}

// "tx" to "rz" or "l", in any case.
std::optional<AsfChannel> ChannelOf(std::string_view word) {
  if (IsKeyword(word, "l")) return AsfChannel{.kind = AsfChannel::Kind::kStretch};
  if (word.size() != 2) return std::nullopt;
  const std::optional<int> axis = AxisOf(word[1]);
  const bool rotation = IsKeyword(word.substr(0, 1), "r");
  if (!axis || !(rotation || IsKeyword(word.substr(0, 1), "t"))) return std::nullopt;
  return AsfChannel{.kind = rotation ? AsfChannel::Kind::kRotation : AsfChannel::Kind::kTranslation,
                    .axis = *axis};
}

class AsfReader {
 public:
  explicit AsfReader(SourceFile file) : scanner_(file, "()") {
    file_.bones.push_back({.name = "root", .channels = {}});
    index_["root"] = 0;
  }

  absl::StatusOr<AsfFile> Read() {
    while (scanner_.NextLine('#')) {
      const std::string_view word = scanner_.TokenOnLine();
      if (word.starts_with(':')) {
        MOTIONDB_RETURN_IF_ERROR(CheckClosed(word));
        section_ = SectionOf(word);
        if (IsKeyword(word, ":name")) file_.name = ToUtf8(scanner_.RestOfLine());
        if (section_ != Section::kOther) MOTIONDB_RETURN_IF_ERROR(EndLine());
      } else {
        MOTIONDB_RETURN_IF_ERROR(ReadLine(word));
      }
    }
    MOTIONDB_RETURN_IF_ERROR(CheckClosed(""));
    if (file_.bones[0].channels.empty()) {
      return scanner_.Expected("a ':root' section with 'order'", "");
    }
    if (!hierarchy_read_) return scanner_.Expected("a ':hierarchy' section", "");
    return InHierarchyOrder();
  }

 private:
  absl::Status EndLine() {
    const std::string_view rest = scanner_.RestOfLine();
    if (rest.empty() || rest.starts_with('#')) return absl::OkStatus();
    return scanner_.Expected("the line to end", rest);
  }

  absl::Status CheckClosed(std::string_view found) const {
    return open_ ? scanner_.Expected("'end'", found) : absl::OkStatus();
  }

  absl::Status ReadLine(std::string_view word) {
    switch (section_) {
      case Section::kNone:
        return scanner_.Expected("a section such as ':version'", word);
      case Section::kUnits:
        return ReadUnit(word);
      case Section::kRoot:
        return ReadRootLine(word);
      case Section::kBones:
        return ReadBoneLine(word);
      case Section::kHierarchy:
        return ReadHierarchyLine(word);
      case Section::kOther:
        break;
    }
    scanner_.RestOfLine();
    return absl::OkStatus();
  }

  absl::Status ReadUnit(std::string_view word) {
    if (IsKeyword(word, "length")) {
      double length = 0;
      MOTIONDB_RETURN_IF_ERROR(scanner_.ReadNumber("the length unit", length));
      if (!(length >= 1e-9)) return scanner_.Expected("a length unit above 0", scanner_.LastRead());
      file_.length_unit = length;
    } else if (IsKeyword(word, "angle")) {
      const std::string_view unit = scanner_.TokenOnLine();
      file_.degrees = IsKeyword(unit, "deg") || IsKeyword(unit, "degrees");
      if (!file_.degrees && !IsKeyword(unit, "rad") && !IsKeyword(unit, "radians")) {
        return scanner_.Expected("'deg' or 'rad'", unit);
      }
    } else {
      scanner_.RestOfLine();  // mass
      return absl::OkStatus();
    }
    return EndLine();
  }

  absl::Status ReadRootLine(std::string_view word) {
    AsfBone& root = file_.bones[0];
    if (IsKeyword(word, "order")) return ReadChannels(root);
    if (IsKeyword(word, "axis")) {
      MOTIONDB_RETURN_IF_ERROR(ReadAxisOrder(root));
    } else if (IsKeyword(word, "position")) {
      MOTIONDB_RETURN_IF_ERROR(ReadVector("the root's position", file_.root_position));
    } else if (IsKeyword(word, "orientation")) {
      MOTIONDB_RETURN_IF_ERROR(ReadVector("the root's orientation", root.axis_angles));
    } else {
      return scanner_.Expected("'order', 'axis', 'position' or 'orientation'", word);
    }
    return EndLine();
  }

  absl::Status ReadBoneLine(std::string_view word) {
    if (IsKeyword(word, "begin")) {
      MOTIONDB_RETURN_IF_ERROR(CheckClosed(word));
      open_ = true;
      bone_ = AsfBone{};
      has_direction_ = has_length_ = false;
      return EndLine();
    }
    if (!open_) return scanner_.Expected("'begin'", word);
    if (IsKeyword(word, "end")) return FinishBone();
    if (IsKeyword(word, "name")) {
      const std::string_view name = scanner_.TokenOnLine();
      if (name.empty()) return scanner_.Expected("the bone's name", name);
      bone_.name = ToUtf8(name);
    } else if (IsKeyword(word, "direction")) {
      MOTIONDB_RETURN_IF_ERROR(ReadVector("the bone's direction", bone_.direction));
      has_direction_ = true;
    } else if (IsKeyword(word, "length")) {
      MOTIONDB_RETURN_IF_ERROR(ReadNumberOnLine("the bone's length", bone_.length));
      has_length_ = true;
    } else if (IsKeyword(word, "axis")) {
      MOTIONDB_RETURN_IF_ERROR(ReadVector("the bone's axis", bone_.axis_angles));
      MOTIONDB_RETURN_IF_ERROR(ReadAxisOrder(bone_));
    } else if (IsKeyword(word, "dof")) {
      return ReadChannels(bone_);
    } else if (IsKeyword(word, "limits")) {
      return ReadLimits();
    } else {
      scanner_.RestOfLine();  // id, bodymass, cofmass
      return absl::OkStatus();
    }
    return EndLine();
  }

  absl::Status FinishBone() {
    MOTIONDB_RETURN_IF_ERROR(EndLine());
    open_ = false;
    if (bone_.name.empty() || !has_direction_ || !has_length_) {
      return scanner_.Error("expected name, direction and length of bone '{}' before its 'end'",
                            bone_.name);
    }
    const double norm = bone_.direction.norm();
    if (norm > 0) bone_.direction /= norm;
    if (!index_.emplace(bone_.name, static_cast<int>(file_.bones.size())).second) {
      return scanner_.Error("expected bone names to differ, found '{}' twice", bone_.name);
    }
    if (file_.bones.size() >= kMaxFileJoints) {
      return scanner_.Error("expected at most {} joints, found bone '{}' after them",
                            kMaxFileJoints, bone_.name);
    }
    file_.bones.push_back(std::move(bone_));
    return absl::OkStatus();
  }

  absl::Status ReadNumberOnLine(std::string_view what, double& value) {
    if (scanner_.TryNumberOnLine(value)) return absl::OkStatus();
    return scanner_.Expected(what, scanner_.LastRead());
  }

  absl::Status ReadVector(std::string_view what, Eigen::Vector3d& vector) {
    for (int i = 0; i < 3; ++i) {
      MOTIONDB_RETURN_IF_ERROR(
          ReadNumberOnLine(fmt::format("{} (number {} of 3)", what, i + 1), vector[i]));
    }
    return absl::OkStatus();
  }

  absl::Status ReadAxisOrder(AsfBone& bone) {
    const std::string_view order = scanner_.TokenOnLine();
    std::array<bool, 3> named = {};
    for (std::size_t i = 0; i < order.size() && i < 3; ++i) {
      if (const auto axis = AxisOf(order[i])) {
        bone.axis_order[i] = *axis;
        named[static_cast<std::size_t>(*axis)] = true;
      }
    }
    if (order.size() == 3 && named[0] && named[1] && named[2]) return absl::OkStatus();
    return scanner_.Expected("an order of axes such as XYZ", order);
  }

  absl::Status ReadChannels(AsfBone& bone) {
    bone.channels.clear();
    for (std::string_view word = scanner_.TokenOnLine(); !word.empty() && !word.starts_with('#');
         word = scanner_.TokenOnLine()) {
      const std::optional<AsfChannel> channel = ChannelOf(word);
      if (!channel) return scanner_.Expected("tx, ty, tz, rx, ry, rz or l", word);
      for (const AsfChannel& earlier : bone.channels) {
        if (earlier.kind == channel->kind && earlier.axis == channel->axis) {
          return scanner_.Error("expected each degree of freedom once, found '{}' twice", word);
        }
      }
      bone.channels.push_back(*channel);
    }
    scanner_.RestOfLine();
    return absl::OkStatus();
  }

  // Reads one pair in parentheses for each degree of freedom, on any number of lines.
  absl::Status ReadLimits() {
    for (AsfChannel& channel : bone_.channels) {
      MOTIONDB_RETURN_IF_ERROR(scanner_.ReadKeyword("("));
      MOTIONDB_RETURN_IF_ERROR(ReadLimit(channel.lower));
      MOTIONDB_RETURN_IF_ERROR(ReadLimit(channel.upper));
      MOTIONDB_RETURN_IF_ERROR(scanner_.ReadKeyword(")"));
      if (channel.lower > channel.upper) std::swap(channel.lower, channel.upper);
    }
    return EndLine();
  }

  absl::Status ReadLimit(double& limit) {
    if (scanner_.TryNumber(limit)) return absl::OkStatus();
    const std::string_view found = scanner_.LastRead();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (IsKeyword(found, "inf") || IsKeyword(found, "+inf")) {
      limit = kInfinity;
    } else if (IsKeyword(found, "-inf")) {
      limit = -kInfinity;
    } else {
      return scanner_.Expected("a limit", found);
    }
    return absl::OkStatus();
  }

  absl::Status ReadHierarchyLine(std::string_view word) {
    if (IsKeyword(word, "begin")) {
      open_ = true;
      return EndLine();
    }
    if (!open_) return scanner_.Expected("'begin'", word);
    if (IsKeyword(word, "end")) {
      open_ = false;
      hierarchy_read_ = true;
      return EndLine();
    }
    MOTIONDB_ASSIGN_OR_RETURN(const int parent, FindBone(word));
    for (std::string_view name = scanner_.TokenOnLine(); !name.empty() && !name.starts_with('#');
         name = scanner_.TokenOnLine()) {
      MOTIONDB_ASSIGN_OR_RETURN(const int child, FindBone(name));
      if (child == 0 || file_.bones[child].parent >= 0) {
        return scanner_.Error("expected one parent for each bone, found another for '{}'",
                              Shown(name));
      }
      file_.bones[child].parent = parent;
    }
    scanner_.RestOfLine();
    return absl::OkStatus();
  }

  absl::StatusOr<int> FindBone(std::string_view name) const {
    const auto found = index_.find(ToUtf8(name));
    if (found == index_.end()) return scanner_.Expected("a bone of ':bonedata'", name);
    return found->second;
  }

  // Sorts the bones: parents before children.
  absl::StatusOr<AsfFile> InHierarchyOrder() {
    std::vector<std::vector<int>> children(file_.bones.size());
    for (int i = static_cast<int>(file_.bones.size()) - 1; i > 0; --i) {
      if (file_.bones[i].parent < 0) {
        return scanner_.Error("expected bone '{}' in ':hierarchy'", file_.bones[i].name);
      }
      children[file_.bones[i].parent].push_back(i);
    }
    const std::ptrdiff_t tips =
        std::count_if(children.begin() + 1, children.end(),
                      [](const std::vector<int>& below) { return below.empty(); });
    if (static_cast<std::ptrdiff_t>(file_.bones.size()) + tips > kMaxFileJoints) {
      return scanner_.Error("expected at most {} joints, found {} bones that end in {} tips",
                            kMaxFileJoints, file_.bones.size(), tips);
    }
    std::vector<AsfBone> ordered;
    std::vector<std::pair<int, int>> open = {{0, -1}};  // bone, index of its parent in `ordered`
    while (!open.empty()) {
      const auto [bone, parent] = open.back();
      open.pop_back();
      const int place = static_cast<int>(ordered.size());
      ordered.push_back(std::move(file_.bones[bone]));
      ordered.back().parent = parent;
      for (const int child : children[bone]) open.emplace_back(child, place);
    }
    if (ordered.size() != file_.bones.size()) {
      return scanner_.Error("expected every bone of ':hierarchy' to descend from the root");
    }
    file_.bones = std::move(ordered);
    return std::move(file_);
  }

  TextScanner scanner_;
  AsfFile file_;
  std::unordered_map<std::string, int> index_;
  Section section_ = Section::kNone;
  bool open_ = false;  // between 'begin' and 'end'
  AsfBone bone_;       // being read
  bool has_direction_ = false;
  bool has_length_ = false;
  bool hierarchy_read_ = false;
};

}  // namespace

absl::StatusOr<AsfFile> ReadAsf(SourceFile file) {
  std::string plain;
  MOTIONDB_ASSIGN_OR_RETURN(file, PlainFile(file, kMaxSkeletonBytes, plain));
  return AsfReader(file).Read();
}

}  // namespace motiondb::core
