#include "import/scene/scene_nodes.h"

#include <cstddef>
#include <string_view>
#include <utility>

namespace motiondb::importer {

namespace {

constexpr std::string_view kChainTag = "_$AssimpFbx$_";

std::string_view NodeName(const aiNode& node) { return {node.mName.data, node.mName.length}; }

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
    const ChainName name = ParseChainName(NodeName(*node));
    if (name.part.empty() || !IsGeometric(name.part)) parts.push_back(node);
    if (name.part.empty() || node->mNumChildren != 1) return node;
    const aiNode* const next = node->mChildren[0];
    if (ParseChainName(NodeName(*next)).owner != name.owner) return node;
    node = next;
  }
}

}  // namespace

std::vector<SceneNode> SceneNodes(const aiScene& scene) {
  std::vector<SceneNode> nodes;
  std::vector<std::pair<const aiNode*, int>> open = {{scene.mRootNode, -1}};
  while (!open.empty()) {
    const auto [first, parent] = open.back();
    open.pop_back();
    // The inverse of an FBX node's geometric transform stands between it and its children.
    const ChainName name = ParseChainName(NodeName(*first));
    const bool undoes_geometry =
        IsGeometric(name.part) && parent >= 0 && NodeName(*nodes[parent].node) == name.owner;
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
    if (ParseChainName(NodeName(*part)).part == "PostRotation") {
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

}  // namespace motiondb::importer
