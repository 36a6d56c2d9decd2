#include "import/scene/gltf_animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::importer {
namespace {

absl::Status ExpectedAt(const GltfDocument& document, std::string_view path, std::string_view what,
                        std::string_view found) {
  return core::InvalidArgument("{}: {}: expected {}, found {}", document.file_name(), path, what,
                               found);
}

absl::Status CheckAccessors(const GltfDocument& document) {
  const GltfJson& accessors = GltfMember(document.json(), "accessors");
  if (accessors.is_null()) return absl::OkStatus();
  if (!accessors.is_array()) {
    return ExpectedAt(document, "accessors", "an array", accessors.type_name());
  }
  for (std::size_t i = 0; i < accessors.size(); ++i) {
    MOTIONDB_ASSIGN_OR_RETURN(const GltfAccessor accessor, document.Accessor(GltfJson(i)));
    const GltfJson& sparse = GltfMember(*accessor.json, "sparse");
    if (sparse.is_null()) continue;
    const auto component = GltfUnsigned(GltfMember(sparse, "indices"), "componentType");
    if (component == kGltfUnsignedByte || component == kGltfUnsignedShort ||
        component == kGltfUnsignedInt) {
      continue;
    }
    return ExpectedAt(document, accessor.path + ".sparse.indices.componentType",
                      "5121, 5123 or 5125", core::Shown(sparse.dump()));
  }
  return absl::OkStatus();
}

// Number of elements for each key of `weights`: the morph targets of the node's mesh.
std::size_t TargetCount(const GltfDocument& document, const GltfJson& node_index) {
  const GltfJson* const node = document.Find("nodes", node_index);
  if (node == nullptr) return 0;
  const GltfJson* const mesh = document.Find("meshes", GltfMember(*node, "mesh"));
  if (mesh == nullptr) return 0;
  const GltfJson& primitives = GltfMember(*mesh, "primitives");
  if (!primitives.is_array() || primitives.empty()) return 0;
  const GltfJson& targets = GltfMember(primitives[0], "targets");
  return targets.is_array() ? targets.size() : 0;
}

// The elements that a path needs.
struct PathElements {
  std::size_t width = 0;
  std::size_t for_each_key = 1;
  bool may_be_integers = false;
};

PathElements ElementsOf(const GltfDocument& document, const GltfJson& target,
                        std::string_view path) {
  if (path == "rotation") return {.width = 4, .may_be_integers = true};
  if (path != "weights") return {.width = 3};
  return {.width = 1,
          .for_each_key = TargetCount(document, GltfMember(target, "node")),
          .may_be_integers = true};
}

absl::Status CheckChannel(const GltfDocument& document, const GltfJson& animation,
                          const GltfJson& channel, const std::string& where) {
  const GltfJson& target = GltfMember(channel, "target");
  const GltfJson& path = GltfMember(target, "path");
  const std::string name = path.is_string() ? path.get<std::string>() : "";
  if (name != "rotation" && name != "translation" && name != "scale" && name != "weights") {
    return absl::OkStatus();  // of an extension: not read
  }
  const GltfJson& samplers = GltfMember(animation, "samplers");
  const auto index = GltfUnsigned(channel, "sampler");
  if (!samplers.is_array() || !index || *index >= samplers.size()) {
    return ExpectedAt(document, where + ".sampler", "a sampler of the animation",
                      core::Shown(GltfMember(channel, "sampler").dump()));
  }
  const GltfJson& sampler = samplers[*index];
  const GltfJson& interpolation = GltfMember(sampler, "interpolation");
  const bool is_cubic = interpolation == "CUBICSPLINE";
  if (!interpolation.is_null() && interpolation != "LINEAR" && interpolation != "STEP" &&
      !is_cubic) {
    return ExpectedAt(document, where + ": interpolation", "LINEAR, STEP or CUBICSPLINE",
                      core::Shown(interpolation.dump()));
  }
  MOTIONDB_ASSIGN_OR_RETURN(const GltfAccessor times,
                            document.Accessor(GltfMember(sampler, "input")));
  if (times.component != kGltfFloat || times.width != 1) {
    return ExpectedAt(document, times.path, "times as floats (SCALAR, componentType 5126)",
                      fmt::format("componentType {}", times.component));
  }
  MOTIONDB_ASSIGN_OR_RETURN(const GltfAccessor values,
                            document.Accessor(GltfMember(sampler, "output")));
  // assimp 5.2 does not check the indices of sparse accessors.
  for (const GltfAccessor& keys : {times, values}) {
    if (keys.json->contains("sparse")) {
      return ExpectedAt(document, keys.path, "keys in full: export them so", "sparse keys");
    }
  }
  const PathElements elements = ElementsOf(document, target, name);
  const bool is_known_component =
      values.component == kGltfFloat ||
      (elements.may_be_integers && values.component != kGltfUnsignedInt);
  if (values.width != elements.width || !is_known_component) {
    return ExpectedAt(
        document, values.path,
        fmt::format("values of the path '{}': {} numbers each, floats{}", name, elements.width,
                    elements.may_be_integers ? " or normalized integers" : ""),
        fmt::format("{} of componentType {}", values.width, values.component));
  }
  const std::size_t expected = times.count * elements.for_each_key * (is_cubic ? 3 : 1);
  if (values.count == expected) return absl::OkStatus();
  return ExpectedAt(document, values.path + ".count",
                    fmt::format("{} for {} times", expected, times.count),
                    std::to_string(values.count));
}

}  // namespace

absl::Status CheckGltf(const GltfDocument& document) {
  MOTIONDB_RETURN_IF_ERROR(CheckAccessors(document));
  const GltfJson& animations = GltfMember(document.json(), "animations");
  if (animations.is_null()) return absl::OkStatus();
  if (!animations.is_array()) {
    return ExpectedAt(document, "animations", "an array", animations.type_name());
  }
  for (std::size_t a = 0; a < animations.size(); ++a) {
    const GltfJson& channels = GltfMember(animations[a], "channels");
    if (!channels.is_array()) {
      return ExpectedAt(document, fmt::format("animations[{}].channels", a), "an array",
                        channels.type_name());
    }
    for (std::size_t c = 0; c < channels.size(); ++c) {
      MOTIONDB_RETURN_IF_ERROR(CheckChannel(document, animations[a], channels[c],
                                            fmt::format("animations[{}].channels[{}]", a, c)));
    }
  }
  return absl::OkStatus();
}

namespace {

KeyInterpolation InterpolationOf(const GltfJson& sampler) {
  const GltfJson& name = GltfMember(sampler, "interpolation");
  if (name == "STEP") return KeyInterpolation::kStep;
  return name == "CUBICSPLINE" ? KeyInterpolation::kCubicSpline : KeyInterpolation::kLinear;
}

bool IsMovement(const GltfJson& path) {
  return path == "rotation" || path == "translation" || path == "scale";
}

// Calls `visit` for each channel that moves a node, with its sampler.
template <typename Visit>
absl::Status ForEachMovement(const GltfJson& animation, const Visit& visit) {
  for (const GltfJson& channel : GltfMember(animation, "channels")) {
    const GltfJson& target = GltfMember(channel, "target");
    if (!IsMovement(GltfMember(target, "path"))) continue;
    const std::size_t sampler = channel.at("sampler").get<std::size_t>();
    MOTIONDB_RETURN_IF_ERROR(visit(target, animation.at("samplers").at(sampler)));
  }
  return absl::OkStatus();
}

// The name that assimp gives to a node.
std::string NodeName(const GltfDocument& document, const GltfJson& index) {
  const GltfJson* const node = document.Find("nodes", index);
  if (node == nullptr) return "";
  const GltfJson& name = GltfMember(*node, "name");
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
bool AssignToChannel(const CurveValues& values, const GltfJson& path, aiNodeAnim& channel) {
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

KeyCurve& CurveAt(const GltfJson& path, ChannelCurves& curves) {
  if (path == "rotation") return curves.rotation;
  return path == "scale" ? curves.scale : curves.translation;
}

absl::Status AddCurves(const GltfDocument& document, const GltfJson& json,
                       const aiAnimation& animation, SceneCurves& curves) {
  std::unordered_map<std::string_view, aiNodeAnim*> channels;
  for (unsigned c = 0; c < animation.mNumChannels; ++c) {
    const aiString& name = animation.mChannels[c]->mNodeName;
    channels.try_emplace({name.data, name.length}, animation.mChannels[c]);
  }
  const double ticks_per_s = animation.mTicksPerSecond > 0 ? animation.mTicksPerSecond : 1;
  return ForEachMovement(json, [&](const GltfJson& target, const GltfJson& sampler) {
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
    const GltfJson& path = target.at("path");
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
  const GltfJson& animations = GltfMember(document.json(), "animations");
  return std::any_of(animations.begin(), animations.end(), [&](const GltfJson& animation) {
    return !ForEachMovement(animation, [&](const GltfJson&, const GltfJson& sampler) {
              const auto accessor = document.Accessor(GltfMember(sampler, "output"));
              const bool is_plain = InterpolationOf(sampler) == KeyInterpolation::kLinear &&
                                    accessor.ok() && accessor->component == kGltfFloat;
              return is_plain ? absl::OkStatus() : absl::UnknownError("");
            }).ok();
  });
}

absl::StatusOr<SceneCurves> ReadGltfCurves(const GltfDocument& document, const aiScene& scene) {
  SceneCurves curves;
  const GltfJson& animations = GltfMember(document.json(), "animations");
  for (std::size_t a = 0; a < animations.size() && a < scene.mNumAnimations; ++a) {
    MOTIONDB_RETURN_IF_ERROR(AddCurves(document, animations[a], *scene.mAnimations[a], curves));
  }
  return curves;
}

}  // namespace motiondb::importer
