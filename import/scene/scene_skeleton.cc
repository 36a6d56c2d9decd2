#include "import/scene/scene_skeleton.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/format/motion_file.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::importer {

namespace {

bool HasMesh(const SceneNode& node) { return node.node->mNumMeshes > 0; }

// Marks the nodes that are joints for their own sake.
std::vector<bool> MarkCores(const aiScene& scene, const std::vector<SceneNode>& nodes,
                            const std::vector<NodeUse>& uses) {
  std::vector<bool> is_core(nodes.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const NodeUse& use = uses[n];
    const bool is_animated = use.has_channel && (use.moves || !HasMesh(nodes[n]));
    const bool is_in_bare_scene = scene.mNumMeshes == 0 && nodes[n].parent >= 0;
    is_core[n] = use.is_bone || (!use.is_view && (is_animated || is_in_bare_scene));
  }
  return is_core;
}

// Number of cores in the subtree of each node.
std::vector<int> CountCores(const std::vector<SceneNode>& nodes, const std::vector<bool>& is_core) {
  std::vector<int> counts(nodes.size());
  for (std::size_t n = nodes.size(); n-- > 0;) {
    counts[n] += is_core[n] ? 1 : 0;
    if (nodes[n].parent >= 0) counts[nodes[n].parent] += counts[n];
  }
  return counts;
}

// For each node: its only child that has cores below it, or -1.
std::vector<int> OnlyCoreChildren(const std::vector<SceneNode>& nodes,
                                  const std::vector<int>& counts) {
  constexpr int kSeveral = -2;
  std::vector<int> only(nodes.size(), -1);
  for (std::size_t n = 1; n < nodes.size(); ++n) {
    int& child = only[nodes[n].parent];
    if (counts[n] > 0) child = child == -1 ? static_cast<int>(n) : kSeveral;
  }
  std::replace(only.begin(), only.end(), kSeveral, -1);
  return only;
}

int FindRoot(const std::vector<SceneNode>& nodes, const std::vector<NodeUse>& uses,
             const std::vector<int>& counts) {
  // The nodes above all cores are a chain from the scene's root; the last has the highest index.
  int root = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (counts[n] == counts[0]) root = static_cast<int>(n);
  }
  for (int above = nodes[root].parent; above >= 0; above = nodes[above].parent) {
    if (uses[above].moves) root = above;  // a camera that carries the figure
  }
  const std::vector<int> only_child = OnlyCoreChildren(nodes, counts);
  const bool is_still =
      std::none_of(uses.begin(), uses.end(), [](const NodeUse& use) { return use.moves; });
  while (!is_still && !uses[root].is_bone && !uses[root].moves && only_child[root] >= 0) {
    root = only_child[root];
  }
  return root;
}

// Marks nodes that end in a node without mesh, camera or light.
std::vector<bool> MarkEndSites(const std::vector<SceneNode>& nodes,
                               const std::vector<NodeUse>& uses) {
  std::vector<bool> has_child(nodes.size());
  std::vector<bool> is_end(nodes.size());
  for (std::size_t n = nodes.size(); n-- > 0;) {
    const bool is_bare = !HasMesh(nodes[n]) && !uses[n].is_view;
    is_end[n] = is_bare && (is_end[n] || !has_child[n]);
    if (nodes[n].parent < 0) continue;
    has_child[nodes[n].parent] = true;
    if (is_end[n]) is_end[nodes[n].parent] = true;
  }
  return is_end;
}

std::string Counted(unsigned long count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace

absl::StatusOr<SceneSkeleton> FindSkeleton(std::string_view file_name, const aiScene& scene,
                                           const std::vector<SceneNode>& nodes,
                                           const std::vector<NodeUse>& uses,
                                           std::vector<std::string>& notes) {
  const std::vector<int> counts = CountCores(nodes, MarkCores(scene, nodes, uses));
  if (counts[0] == 0) {
    return core::InvalidArgument("{}: has no animated skeleton: {}", file_name,
                                 SceneContent(scene, nodes));
  }
  const int root = FindRoot(nodes, uses, counts);
  const std::vector<bool> is_end = MarkEndSites(nodes, uses);
  SceneSkeleton skeleton;
  for (int above = nodes[root].parent; above >= 0; above = nodes[above].parent) {
    for (auto part = nodes[above].parts.rbegin(); part != nodes[above].parts.rend(); ++part) {
      skeleton.scene_from_root_parent =
          ToAffine((*part)->mTransformation) * skeleton.scene_from_root_parent;
    }
  }
  core::UniqueNames names;
  std::vector<int> joint_of(nodes.size(), -1);
  for (std::size_t n = static_cast<std::size_t>(root); n < nodes.size(); ++n) {
    const bool is_root = static_cast<int>(n) == root;
    const int parent = is_root || nodes[n].parent < 0 ? -1 : joint_of[nodes[n].parent];
    if (!is_root && (parent < 0 || (counts[n] == 0 && !is_end[n]))) continue;
    joint_of[n] = static_cast<int>(skeleton.joints.size());
    const std::string_view name(nodes[n].node->mName.data, nodes[n].node->mName.length);
    skeleton.joints.push_back(
        {.name =
             names.Add(name.empty() ? fmt::format("joint {}", joint_of[n] + 1) : std::string(name)),
         .node = static_cast<int>(n),
         .parent = parent});
    if (std::ssize(skeleton.joints) > core::kMaxFileJoints) {
      return core::InvalidArgument("{}: has more than {} joints: {}", file_name,
                                   core::kMaxFileJoints, SceneContent(scene, nodes));
    }
  }
  if (std::string note = names.Note(); !note.empty()) notes.push_back(std::move(note));
  return skeleton;
}

std::string SceneContent(const aiScene& scene, const std::vector<SceneNode>& nodes) {
  return fmt::format("{}, {}", Counted(scene.mNumMeshes, "mesh", "meshes"),
                     Counted(nodes.size(), "node", "nodes"));
}

}  // namespace motiondb::importer
