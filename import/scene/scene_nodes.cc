#include "import/scene/scene_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::importer {
namespace {

constexpr std::string_view kChainTag = "_$AssimpFbx$_";

// A node of a chain: the name of the FBX node, and the part of its transform.
struct ChainName {
  std::string_view owner;
  std::string_view part;  // empty: no node of a chain
};

ChainName ParseChainName(std::string_view name) {
  const std::size_t tag = name.rfind(kChainTag);
  if (tag == name.npos) return {name, ""};
  return {name.substr(0, tag), name.substr(tag + kChainTag.size())};
}

bool IsGeometric(std::string_view part) { return part.starts_with("Geometric"); }

// Follows the chain from `first` to its last node, which is returned; `parts` gets those that move
// the node's children.
const aiNode* FollowChain(const aiNode* first, std::vector<const aiNode*>& parts) {
  const aiNode* node = first;
  while (true) {
    const ChainName name = ParseChainName(NameView(node->mName));
    if (name.part.empty() || !IsGeometric(name.part)) parts.push_back(node);
    if (name.part.empty() || node->mNumChildren != 1) return node;
    const aiNode* const next = node->mChildren[0];
    if (ParseChainName(NameView(next->mName)).owner != name.owner) return node;
    node = next;
  }
}

}  // namespace

std::string_view NameView(const aiString& name) { return {name.data, name.length}; }

std::vector<SceneNode> SceneNodes(const aiScene& scene) {
  std::vector<SceneNode> nodes;
  std::vector<std::pair<const aiNode*, int>> open = {{scene.mRootNode, -1}};
  while (!open.empty()) {
    const auto [first, parent] = open.back();
    open.pop_back();
    // The inverse of an FBX node's geometric transform stands between it and its children.
    const ChainName name = ParseChainName(NameView(first->mName));
    const bool undoes_geometry =
        IsGeometric(name.part) && parent >= 0 && NameView(nodes[parent].node->mName) == name.owner;
    const aiNode* last = first;
    int index = parent;
    if (!undoes_geometry) {
      SceneNode added{.node = nullptr, .parent = parent, .parts = {}};
      last = added.node = FollowChain(first, added.parts);
      index = static_cast<int>(nodes.size());
      nodes.push_back(std::move(added));
    }
    for (unsigned i = last->mNumChildren; i-- > 0;) open.emplace_back(last->mChildren[i], index);
  }
  return nodes;
}

Eigen::Matrix3d InversePostRotation(const SceneNode& node) {
  for (const aiNode* part : node.parts) {
    if (ParseChainName(NameView(part->mName)).part == "PostRotation") {
      return ToAffine(part->mTransformation).linear();
    }
  }
  return Eigen::Matrix3d::Identity();
}

Eigen::Affine3d ToAffine(const aiMatrix4x4& matrix) {
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  affine.linear() << matrix.a1, matrix.a2, matrix.a3, matrix.b1, matrix.b2, matrix.b3, matrix.c1,
      matrix.c2, matrix.c3;
  affine.translation() << matrix.a4, matrix.b4, matrix.c4;
  return affine;
}

namespace {

constexpr double kSameValue = 1e-6;
constexpr double kSameRotation = 1e-5;         // of the numbers of a unit quaternion
constexpr std::size_t kMaxListedBytes = 2048;  // the status of a call has at most 8 KiB

bool Differs(const aiVector3D& a, const aiVector3D& b) {
  return !((a - b).Length() <= kSameValue * std::max<double>(1, a.Length()));
}

bool Differs(const aiQuaternion& a, const aiQuaternion& b) {
  const auto distance = [&](float sign) {
    return std::max({std::abs(a.w - sign * b.w), std::abs(a.x - sign * b.x),
                     std::abs(a.y - sign * b.y), std::abs(a.z - sign * b.z)});
  };
  return !(std::min(distance(1), distance(-1)) <= kSameRotation);
}

template <typename Key>
bool KeysDiffer(const Key* keys, unsigned count) {
  return std::any_of(keys, keys + count,
                     [&](const Key& key) { return Differs(keys->mValue, key.mValue); });
}

bool ChannelMoves(const aiNodeAnim& channel) {
  return KeysDiffer(channel.mPositionKeys, channel.mNumPositionKeys) ||
         KeysDiffer(channel.mRotationKeys, channel.mNumRotationKeys) ||
         KeysDiffer(channel.mScalingKeys, channel.mNumScalingKeys);
}

// Returns the index of the node with this name, or -1.
int NodeOf(const NodePlaces& places, const aiString& name) {
  const auto place = places.find(NameView(name));
  return place == places.end() ? -1 : place->second.node;
}

bool TakeMoves(const aiAnimation& animation, const NodePlaces& places,
               const std::vector<NodeUse>& uses) {
  return std::any_of(animation.mChannels, animation.mChannels + animation.mNumChannels,
                     [&](const aiNodeAnim* channel) {
                       const int node = NodeOf(places, channel->mNodeName);
                       return node >= 0 && !uses[node].is_view && ChannelMoves(*channel);
                     });
}

const SceneTake* FindTake(const std::vector<SceneTake>& takes, std::string_view wanted) {
  const auto named = std::find_if(takes.begin(), takes.end(),
                                  [&](const SceneTake& take) { return take.name == wanted; });
  if (named != takes.end()) return &*named;
  std::size_t number = 0;
  const char* const end = wanted.data() + wanted.size();
  const auto [rest, error] = std::from_chars(wanted.data(), end, number);
  const bool is_number = error == std::errc() && rest == end && number >= 1;
  return is_number && number <= takes.size() ? &takes[number - 1] : nullptr;
}

absl::Status TakeRequired(std::string_view file_name, const std::vector<SceneTake>& takes,
                          std::string_view wanted) {
  std::string list;
  nlohmann::json names = nlohmann::json::array();
  for (const SceneTake& take : takes) {
    if (list.size() + take.name.size() > kMaxListedBytes) {
      list += fmt::format(" and {} more", takes.size() - names.size());
      break;
    }
    list += (names.empty() ? "" : ", ") + take.name;
    names.push_back(take.name);
  }
  const char* const plural = takes.size() == 1 ? "" : "s";
  const absl::Status status =
      wanted.empty()
          ? core::InvalidArgument("{}: has {} takes ({}): name one", file_name, takes.size(), list)
          : core::InvalidArgument("{}: has no take '{}', but {} take{} ({})", file_name,
                                  core::Shown(wanted), takes.size(), plural, list);
  absl::Status listed = core::WithResource("takes", names.dump(), status);
  listed = core::WithResource("take_count", std::to_string(takes.size()), std::move(listed));
  return core::WithReason(wanted.empty() ? "TAKE_REQUIRED" : "TAKE_NOT_FOUND", std::move(listed));
}

}  // namespace

NodePlaces FindPlaces(const std::vector<SceneNode>& nodes) {
  NodePlaces places;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    for (std::size_t p = 0; p < nodes[n].parts.size(); ++p) {
      const auto [place, is_new] =
          places.try_emplace(NameView(nodes[n].parts[p]->mName),
                             NodePlace{.node = static_cast<int>(n), .part = static_cast<int>(p)});
      if (!is_new) place->second.is_repeated = true;
    }
  }
  return places;
}

std::vector<NodeUse> UsesOfNodes(const aiScene& scene, const std::vector<SceneNode>& nodes,
                                 const NodePlaces& places) {
  std::vector<NodeUse> uses(nodes.size());
  const auto use_of = [&](const aiString& name) {
    const int node = NodeOf(places, name);
    return node < 0 ? nullptr : &uses[node];
  };
  for (unsigned i = 0; i < scene.mNumCameras; ++i) {
    if (NodeUse* use = use_of(scene.mCameras[i]->mName)) use->is_view = true;
  }
  for (unsigned i = 0; i < scene.mNumLights; ++i) {
    if (NodeUse* use = use_of(scene.mLights[i]->mName)) use->is_view = true;
  }
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[i];
    for (unsigned b = 0; b < mesh.mNumBones; ++b) {
      if (NodeUse* use = use_of(mesh.mBones[b]->mName)) use->is_bone = true;
    }
  }
  for (unsigned i = 0; i < scene.mNumAnimations; ++i) {
    const aiAnimation& animation = *scene.mAnimations[i];
    for (unsigned c = 0; c < animation.mNumChannels; ++c) {
      NodeUse* const use = use_of(animation.mChannels[c]->mNodeName);
      if (use == nullptr) continue;
      use->has_channel = true;
      use->moves = use->moves || ChannelMoves(*animation.mChannels[c]);
    }
  }
  return uses;
}

std::vector<SceneTake> FindTakes(const aiScene& scene, const NodePlaces& places,
                                 const std::vector<NodeUse>& uses) {
  std::vector<SceneTake> all;
  std::vector<SceneTake> moving;
  core::UniqueNames names;
  for (unsigned i = 0; i < scene.mNumAnimations; ++i) {
    const aiAnimation& animation = *scene.mAnimations[i];
    const std::string_view name = NameView(animation.mName);
    const bool has_name = name.find_first_not_of(" \t\r\n") != name.npos;
    all.push_back({.name = names.Add(has_name ? std::string(name) : fmt::format("take {}", i + 1)),
                   .animation = &animation});
    if (TakeMoves(animation, places, uses)) moving.push_back(all.back());
  }
  return moving.empty() ? all : moving;
}

absl::StatusOr<SceneTake> ChooseTake(std::string_view file_name,
                                     const std::vector<SceneTake>& takes, std::string_view wanted) {
  if (wanted.empty() && takes.size() == 1) return takes.front();
  const SceneTake* const found = wanted.empty() ? nullptr : FindTake(takes, wanted);
  if (found == nullptr) return TakeRequired(file_name, takes, wanted);
  return *found;
}

}  // namespace motiondb::importer
