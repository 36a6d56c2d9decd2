#include "core/format/bvh_hierarchy.h"

#include <algorithm>
#include <array>

#include "core/format/motion_file.h"
#include "core/format/text_scanner.h"

namespace motiondb::core {
namespace {

constexpr int kMaxChannels = 6;

struct ChannelName {
  std::string_view name;  // lower case
  BvhChannel channel;
};

constexpr std::array<ChannelName, 6> kChannelNames = {{
    {"xposition", {Dof::Kind::kTranslation, 0}},
    {"yposition", {Dof::Kind::kTranslation, 1}},
    {"zposition", {Dof::Kind::kTranslation, 2}},
    {"xrotation", {Dof::Kind::kRotation, 0}},
    {"yrotation", {Dof::Kind::kRotation, 1}},
    {"zrotation", {Dof::Kind::kRotation, 2}},
}};

// Reads joints into a list. Not recursive: nesting depth does not use stack.
class HierarchyReader {
 public:
  explicit HierarchyReader(TextScanner& scanner) : scanner_(scanner) {}

  absl::StatusOr<std::vector<BvhJoint>> Read() {
    MOTIONDB_RETURN_IF_ERROR(scanner_.ReadKeyword("hierarchy"));
    while (true) {
      const std::string_view token = scanner_.Token();
      if (current_ < 0 && !joints_.empty() && IsKeyword(token, "motion")) return Finish();
      MOTIONDB_RETURN_IF_ERROR(current_ < 0 ? ReadOutside(token) : ReadInside(token));
    }
  }

  const UniqueNames& names() const { return names_; }

 private:
  absl::StatusOr<std::vector<BvhJoint>> Finish() {
    const bool moves = std::any_of(joints_.begin(), joints_.end(),
                                   [](const BvhJoint& joint) { return !joint.channels.empty(); });
    if (!moves) return scanner_.Error("expected at least one joint with channels before MOTION");
    // Afterwards, so that a joint "x_end" keeps its name.
    for (BvhJoint& joint : joints_) {
      if (joint.is_end_site) joint.name = names_.Add(joints_[joint.parent].name + "_end");
    }
    return std::move(joints_);
  }

  absl::Status ReadOutside(std::string_view token) {
    if (IsKeyword(token, "root")) return OpenJoint();
    return scanner_.Expected(joints_.empty() ? "'ROOT'" : "'MOTION'", token);
  }

  absl::Status ReadInside(std::string_view token) {
    const bool end_site = joints_[current_].is_end_site;
    if (IsKeyword(token, "offset")) return ReadOffset();
    if (IsKeyword(token, "channels")) return ReadChannels();
    if (token == "}") return Close();
    if (!end_site && IsKeyword(token, "joint")) return OpenJoint();
    if (!end_site && (IsKeyword(token, "end") || IsKeyword(token, "endsite"))) return OpenEndSite();
    return scanner_.Expected(
        end_site ? "'OFFSET' or '}'" : "'OFFSET', 'CHANNELS', 'JOINT', 'End Site' or '}'", token);
  }

  absl::Status OpenJoint() {
    const std::string_view name = scanner_.RestOfLine("{");
    if (name.empty()) return scanner_.Expected("the joint's name", "");
    return Open({.name = names_.Add(name), .parent = current_, .channels = {}});
  }

  absl::Status OpenEndSite() {
    scanner_.RestOfLine("{");  // "Site", and a name that some writers add
    return Open({.name = "", .parent = current_, .channels = {}, .is_end_site = true});
  }

  absl::Status Open(BvhJoint joint) {
    if (joints_.size() >= kMaxFileJoints) {
      return scanner_.Error("expected at most {} joints, found joint '{}' after them",
                            kMaxFileJoints, joint.name);
    }
    const std::string_view brace = scanner_.Token();
    if (brace != "{") {
      return scanner_.Expected(fmt::format("'{{' after joint '{}'", joint.name), brace);
    }
    current_ = static_cast<int>(joints_.size());
    joints_.push_back(std::move(joint));
    has_offset_.push_back(false);
    has_channels_.push_back(false);
    return absl::OkStatus();
  }

  absl::Status Close() {
    if (!has_offset_[current_]) {
      return scanner_.Error("expected 'OFFSET' in joint '{}', which ends here",
                            joints_[current_].name);
    }
    current_ = joints_[current_].parent;
    return absl::OkStatus();
  }

  absl::Status ReadOffset() {
    BvhJoint& joint = joints_[current_];
    if (has_offset_[current_]) {
      return scanner_.Error("expected one OFFSET in joint '{}', found a second", joint.name);
    }
    has_offset_[current_] = true;
    for (int axis = 0; axis < 3; ++axis) {
      MOTIONDB_RETURN_IF_ERROR(
          scanner_.ReadNumber("a number (OFFSET has three)", joint.offset[axis]));
    }
    return absl::OkStatus();
  }

  absl::Status ReadChannels() {
    BvhJoint& joint = joints_[current_];
    if (has_channels_[current_]) {
      return scanner_.Error("expected one CHANNELS in joint '{}', found a second", joint.name);
    }
    has_channels_[current_] = true;
    int count = 0;
    MOTIONDB_RETURN_IF_ERROR(
        scanner_.ReadInteger("the number of channels", 0, kMaxChannels, count));
    for (int i = 0; i < count; ++i) MOTIONDB_RETURN_IF_ERROR(ReadChannel(joint, i, count));
    return absl::OkStatus();
  }

  absl::Status ReadChannel(BvhJoint& joint, int index, int count) {
    const std::string_view token = scanner_.Token();
    const auto known =
        std::find_if(kChannelNames.begin(), kChannelNames.end(),
                     [&](const ChannelName& name) { return IsKeyword(token, name.name); });
    if (known == kChannelNames.end()) {
      return scanner_.Expected(
          fmt::format("channel {} of {} of joint '{}' (Xposition to Zrotation)", index + 1, count,
                      joint.name),
          token);
    }
    for (const BvhChannel& earlier : joint.channels) {
      if (earlier.kind == Dof::Kind::kTranslation && known->channel.kind == earlier.kind &&
          known->channel.axis == earlier.axis) {
        return scanner_.Error("expected each position channel of joint '{}' once, found '{}' twice",
                              joint.name, Shown(token));
      }
    }
    joint.channels.push_back(known->channel);
    return absl::OkStatus();
  }

  TextScanner& scanner_;
  UniqueNames names_;
  std::vector<BvhJoint> joints_;
  std::vector<bool> has_offset_;
  std::vector<bool> has_channels_;
  int current_ = -1;  // the joint whose braces are open
};

}  // namespace

absl::StatusOr<std::vector<BvhJoint>> ReadBvhHierarchy(TextScanner& scanner,
                                                       std::vector<std::string>& notes) {
  HierarchyReader reader(scanner);
  auto joints = reader.Read();
  if (std::string note = reader.names().Note(); !note.empty()) notes.push_back(std::move(note));
  return joints;
}

}  // namespace motiondb::core
