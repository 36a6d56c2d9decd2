#include "import/scene/scene_tracks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::importer {

namespace {

Eigen::Vector3d ToEigen(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Eigen::Quaterniond ToEigen(const aiQuaternion& q) {
  return Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

bool IsUsable(const aiVector3D& v) { return ToEigen(v).allFinite(); }

// Exporters round quaternions to few digits, but not to a half.
bool IsUsable(const aiQuaternion& q) {
  const double norm = Eigen::Vector4d(q.w, q.x, q.y, q.z).norm();
  return norm > 0.5 && norm < 2;
}

std::string ShownValue(const aiVector3D& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

std::string ShownValue(const aiQuaternion& q) {
  return fmt::format("(w {}, x {}, y {}, z {})", q.w, q.x, q.y, q.z);
}

// Checks the keys of one channel.
class KeyCheck {
 public:
  KeyCheck(std::string_view file_name, const SceneTake& take, const aiNodeAnim& channel,
           bool may_be_negative)
      : file_name_(file_name), take_(take), channel_(channel), may_be_negative_(may_be_negative) {}

  absl::Status Check() const {
    MOTIONDB_RETURN_IF_ERROR(CheckKeys("translation", "three numbers", channel_.mPositionKeys,
                                       channel_.mNumPositionKeys));
    MOTIONDB_RETURN_IF_ERROR(CheckKeys("rotation", "a unit quaternion", channel_.mRotationKeys,
                                       channel_.mNumRotationKeys));
    return CheckKeys("scale", "three numbers", channel_.mScalingKeys, channel_.mNumScalingKeys);
  }

 private:
  template <typename Key>
  absl::Status CheckKeys(std::string_view kind, std::string_view expected, const Key* keys,
                         unsigned count) const {
    if (count == 0 || keys == nullptr) {
      return core::InvalidArgument("{}: expected a {} key", Where(), kind);
    }
    for (unsigned k = 0; k < count; ++k) {
      const double time = keys[k].mTime;
      if (!std::isfinite(time) || (time < 0 && !may_be_negative_)) {
        return core::InvalidArgument("{}, {} key {}: expected a time from 0, found {}", Where(),
                                     kind, k + 1, time);
      }
      if (k > 0 && time < keys[k - 1].mTime) {
        return core::InvalidArgument("{}, {} key {}: expected a time from {} (ticks), found {}",
                                     Where(), kind, k + 1, keys[k - 1].mTime, time);
      }
      if (!IsUsable(keys[k].mValue)) {
        return core::InvalidArgument("{}, {} key {}: expected {}, found {}", Where(), kind, k + 1,
                                     expected, ShownValue(keys[k].mValue));
      }
    }
    return absl::OkStatus();
  }

  std::string Where() const {
    return fmt::format("{}: take '{}', node '{}'", file_name_, core::Shown(take_.name),
                       core::Shown(NameView(channel_.mNodeName)));
  }

  const std::string_view file_name_;
  const SceneTake& take_;
  const aiNodeAnim& channel_;
  const bool may_be_negative_;
};

Eigen::Vector3d Coordinates(const aiVector3D& v) { return ToEigen(v); }
// In the order of glTF, not normalized.
Eigen::Vector4d Coordinates(const aiQuaternion& q) { return {q.x, q.y, q.z, q.w}; }

Eigen::Vector3d Interpolate(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double t) {
  return a + t * (b - a);
}

Eigen::Quaterniond Interpolate(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double t) {
  return a.slerp(t, b);
}

Eigen::Vector3d FromCoordinates(const Eigen::Vector3d& v) { return v; }
Eigen::Quaterniond FromCoordinates(const Eigen::Vector4d& q) {
  return Eigen::Quaterniond(q).normalized();
}

// Returns the cubic spline from key `k` to the next one. `t`: 0 to 1; `span`: in ticks.
template <typename Key>
auto SplineAt(const Key* keys, const std::vector<float>& tangents, unsigned k, double t,
              double span) {
  using Vector = decltype(Coordinates(keys[0].mValue));
  constexpr Eigen::Index kWidth = Vector::RowsAtCompileTime;
  const auto tangent = [&](std::size_t i) -> Vector {
    return Eigen::Map<const Eigen::Matrix<float, kWidth, 1>>(tangents.data() + i * kWidth)
        .template cast<double>();
  };
  const double t2 = t * t;
  const double t3 = t2 * t;
  const Vector value = (2 * t3 - 3 * t2 + 1) * Coordinates(keys[k].mValue) +
                       (t3 - 2 * t2 + t) * span * tangent(2 * std::size_t{k} + 1) +
                       (3 * t2 - 2 * t3) * Coordinates(keys[k + 1].mValue) +
                       (t3 - t2) * span * tangent(2 * std::size_t{k} + 2);
  return FromCoordinates(value);
}

// Moves `key` to the last key at or before `ticks`, and returns the value at `ticks`.
template <typename Key>
auto ValueAt(const Key* keys, unsigned count, const KeyCurve* curve, double ticks, unsigned& key) {
  while (key + 1 < count && keys[key + 1].mTime <= ticks) ++key;
  const auto value = ToEigen(keys[key].mValue);
  if (key + 1 == count || ticks <= keys[key].mTime) return value;
  const double span = keys[key + 1].mTime - keys[key].mTime;  // above 0: the next key is later
  const double t = (ticks - keys[key].mTime) / span;
  switch (curve == nullptr ? KeyInterpolation::kLinear : curve->interpolation) {
    case KeyInterpolation::kStep:
      return value;
    case KeyInterpolation::kCubicSpline:
      return SplineAt(keys, curve->tangents, key, t, span);
    default:
      return Interpolate(value, ToEigen(keys[key + 1].mValue), t);
  }
}

// Puts the channels of the take at the parts of the joints' nodes. An FBX node X with a channel "X"
// and pre- or post-rotations is a special case: the channel has the whole transform, translation *
// pre * rotation * post * scale; FBX has the inverse of `post`.
void PutChannel(const SceneNode& node, const NodePlace& place, const aiNodeAnim& channel,
                const SceneCurves& curves, JointTrack& track) {
  const bool is_whole = place.part + 1 == static_cast<int>(node.parts.size());
  if (is_whole && node.parts.size() > 1) {
    const Eigen::Matrix3d inverse_post = InversePostRotation(node);
    track.parts = {{.channel = &channel, .after_rotation = inverse_post * inverse_post}};
  } else if (place.part < std::ssize(track.parts)) {
    const auto found = curves.find(&channel);
    track.parts[place.part].channel = &channel;
    track.parts[place.part].curves = found == curves.end() ? nullptr : &found->second;
  }
}

}  // namespace

absl::StatusOr<std::vector<JointTrack>> FindTracks(
    std::string_view file_name, core::FileFormat format, const std::vector<SceneNode>& nodes,
    const NodePlaces& places, const SceneSkeleton& skeleton, const SceneTake& take,
    const SceneCurves& curves) {
  if (const double ticks = take.animation->mTicksPerSecond;
      !(ticks >= 0) || !std::isfinite(ticks)) {
    return core::InvalidArgument("{}: take '{}': expected a frame rate above 0, found {}",
                                 file_name, core::Shown(take.name), ticks);
  }
  std::vector<JointTrack> tracks(skeleton.joints.size());
  std::vector<int> joint_of(nodes.size(), -1);
  for (std::size_t j = 0; j < tracks.size(); ++j) {
    const SceneNode& node = nodes[skeleton.joints[j].node];
    joint_of[skeleton.joints[j].node] = static_cast<int>(j);
    for (const aiNode* part : node.parts) {
      tracks[j].parts.push_back({.rest = ToAffine(part->mTransformation)});
      tracks[j].rest = tracks[j].rest * tracks[j].parts.back().rest;
    }
    if (!tracks[j].rest.matrix().allFinite()) {
      return core::InvalidArgument("{}: node '{}': its transform is not finite", file_name,
                                   core::Shown(skeleton.joints[j].name));
    }
  }
  for (unsigned c = 0; c < take.animation->mNumChannels; ++c) {
    const aiNodeAnim& channel = *take.animation->mChannels[c];
    const std::string_view name = NameView(channel.mNodeName);
    const auto place = places.find(name);
    if (place == places.end() || joint_of[place->second.node] < 0) continue;
    if (place->second.is_repeated) {
      return core::InvalidArgument(
          "{}: several nodes have the name '{}', so that its animation is ambiguous", file_name,
          core::Shown(name));
    }
    MOTIONDB_RETURN_IF_ERROR(
        KeyCheck(file_name, take, channel, format == core::FileFormat::kFbx).Check());
    PutChannel(nodes[place->second.node], place->second, channel, curves,
               tracks[joint_of[place->second.node]]);
  }
  return tracks;
}

TrackCursor::TrackCursor(const JointTrack& track) : track_(track), keys_(track.parts.size()) {}

Eigen::Affine3d TrackCursor::LocalAt(double ticks) {
  Eigen::Affine3d local = Eigen::Affine3d::Identity();
  for (std::size_t i = 0; i < track_.parts.size(); ++i) {
    const TrackPart& part = track_.parts[i];
    if (part.channel == nullptr) {
      local = local * part.rest;
      continue;
    }
    const aiNodeAnim& channel = *part.channel;
    const ChannelCurves* const curves = part.curves;
    Keys& at = keys_[i];
    Eigen::Affine3d moved;
    moved.linear() = ValueAt(channel.mRotationKeys, channel.mNumRotationKeys,
                             curves ? &curves->rotation : nullptr, ticks, at.rotation) *
                     part.after_rotation *
                     ValueAt(channel.mScalingKeys, channel.mNumScalingKeys,
                             curves ? &curves->scale : nullptr, ticks, at.scale)
                         .asDiagonal();
    moved.translation() = ValueAt(channel.mPositionKeys, channel.mNumPositionKeys,
                                  curves ? &curves->translation : nullptr, ticks, at.position);
    moved.makeAffine();
    local = local * moved;
  }
  return local;
}

}  // namespace motiondb::importer
