#include "import/scene/gltf_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::importer {

namespace {

using CurveJson = nlohmann::json;

KeyInterpolation InterpolationOf(const CurveJson& sampler) {
  const CurveJson& name = GltfMember(sampler, "interpolation");
  if (name == "STEP") return KeyInterpolation::kStep;
  return name == "CUBICSPLINE" ? KeyInterpolation::kCubicSpline : KeyInterpolation::kLinear;
}

bool IsMovement(const CurveJson& path) {
  return path == "rotation" || path == "translation" || path == "scale";
}

// Calls `visit` for each channel that moves a node, with its sampler.
template <typename Visit>
absl::Status ForEachMovement(const CurveJson& animation, const Visit& visit) {
  for (const CurveJson& channel : GltfMember(animation, "channels")) {
    const CurveJson& target = GltfMember(channel, "target");
    if (!IsMovement(GltfMember(target, "path"))) continue;
    const std::size_t sampler = channel.at("sampler").get<std::size_t>();
    MOTIONDB_RETURN_IF_ERROR(visit(target, animation.at("samplers").at(sampler)));
  }
  return absl::OkStatus();
}

// The name that assimp gives to a node.
std::string NodeName(const GltfDocument& document, const CurveJson& index) {
  const CurveJson* const node = document.Find("nodes", index);
  if (node == nullptr) return "";
  const CurveJson& name = GltfMember(*node, "name");
  if (name.is_string() && !name.get_ref<const std::string&>().empty()) {
    return aiString(name.get_ref<const std::string&>()).C_Str();
  }
  return fmt::format("nodes_{}", index.get<std::size_t>());
}

// The numbers of one component, which has `width` of them for each key.
struct CurveValues {
  std::vector<float> numbers = {};
  std::size_t width = 0;
  bool is_cubic = false;

  const float* key(std::size_t k) const {
    return numbers.data() + (is_cubic ? 3 * k + 1 : k) * width;
  }
};

void Assign(const float* v, aiVector3D& value) { value = {v[0], v[1], v[2]}; }
void Assign(const float* q, aiQuaternion& value) { value = {q[3], q[0], q[1], q[2]}; }

template <typename Key>
bool AssignKeys(const CurveValues& values, Key* keys, unsigned count) {
  const std::size_t needed = std::size_t{count} * values.width * (values.is_cubic ? 3 : 1);
  if (values.numbers.size() != needed) return false;
  for (unsigned k = 0; k < count; ++k) Assign(values.key(k), keys[k].mValue);
  return true;
}

// Puts the values at the channel's keys; false if it has another number of keys.
bool AssignToChannel(const CurveValues& values, const CurveJson& path, aiNodeAnim& channel) {
  if (path == "rotation") {
    return AssignKeys(values, channel.mRotationKeys, channel.mNumRotationKeys);
  }
  return path == "scale" ? AssignKeys(values, channel.mScalingKeys, channel.mNumScalingKeys)
                         : AssignKeys(values, channel.mPositionKeys, channel.mNumPositionKeys);
}

KeyCurve CurveOf(const CurveValues& values, KeyInterpolation interpolation, double ticks_per_s) {
  KeyCurve curve{.interpolation = interpolation};
  if (!values.is_cubic) return curve;
  const auto scale = static_cast<float>(1 / ticks_per_s);
  const std::size_t three = 3 * values.width;  // tangent before, value, tangent after
  for (std::size_t i = 0; i < values.numbers.size(); ++i) {
    const bool is_value = i % three / values.width == 1;
    if (!is_value) curve.tangents.push_back(scale * values.numbers[i]);
  }
  return curve;
}

KeyCurve& CurveAt(const CurveJson& path, ChannelCurves& curves) {
  if (path == "rotation") return curves.rotation;
  return path == "scale" ? curves.scale : curves.translation;
}

absl::Status AddCurves(const GltfDocument& document, const CurveJson& json,
                       const aiAnimation& animation, SceneCurves& curves) {
  std::unordered_map<std::string_view, aiNodeAnim*> channels;
  for (unsigned c = 0; c < animation.mNumChannels; ++c) {
    const aiString& name = animation.mChannels[c]->mNodeName;
    channels.try_emplace({name.data, name.length}, animation.mChannels[c]);
  }
  const double ticks_per_s = animation.mTicksPerSecond > 0 ? animation.mTicksPerSecond : 1;
  return ForEachMovement(json, [&](const CurveJson& target, const CurveJson& sampler) {
    const auto channel = channels.find(NodeName(document, GltfMember(target, "node")));
    if (channel == channels.end()) return absl::OkStatus();
    const KeyInterpolation interpolation = InterpolationOf(sampler);
    MOTIONDB_ASSIGN_OR_RETURN(const GltfAccessor accessor, document.Accessor(sampler.at("output")));
    if (interpolation == KeyInterpolation::kLinear && accessor.component == kGltfFloat) {
      return absl::OkStatus();
    }
    CurveValues values{.width = accessor.width,
                       .is_cubic = interpolation == KeyInterpolation::kCubicSpline};
    MOTIONDB_ASSIGN_OR_RETURN(values.numbers, document.Numbers(accessor));
    const CurveJson& path = target.at("path");
    if (!AssignToChannel(values, path, *channel->second)) {
      return core::InvalidArgument("{}: {}: several channels move one component of a node",
                                   document.file_name(), accessor.path);
    }
    CurveAt(path, curves[channel->second]) = CurveOf(values, interpolation, ticks_per_s);
    return absl::OkStatus();
  });
}

}  // namespace

bool NeedsGltfCurves(const GltfDocument& document) {
  const CurveJson& animations = GltfMember(document.json(), "animations");
  return std::any_of(animations.begin(), animations.end(), [&](const CurveJson& animation) {
    return !ForEachMovement(animation, [&](const CurveJson&, const CurveJson& sampler) {
              const auto accessor = document.Accessor(GltfMember(sampler, "output"));
              const bool is_plain = InterpolationOf(sampler) == KeyInterpolation::kLinear &&
                                    accessor.ok() && accessor->component == kGltfFloat;
              return is_plain ? absl::OkStatus() : absl::UnknownError("");
            }).ok();
  });
}

absl::StatusOr<SceneCurves> ReadGltfCurves(const GltfDocument& document, const aiScene& scene) {
  SceneCurves curves;
  const CurveJson& animations = GltfMember(document.json(), "animations");
  for (std::size_t a = 0; a < animations.size() && a < scene.mNumAnimations; ++a) {
    MOTIONDB_RETURN_IF_ERROR(AddCurves(document, animations[a], *scene.mAnimations[a], curves));
  }
  return curves;
}

}  // namespace motiondb::importer
