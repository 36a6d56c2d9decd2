// The nodes of a scene as a flat list, its takes, and the nodes that they animate.
#pragma once

#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::importer {

// Returns the bytes of one of assimp's strings.
std::string_view NameView(const aiString& name);

// The transform from the node to its parent is the product of those of `parts`, leftmost first.
struct SceneNode {
  const aiNode* node = nullptr;  // has the name and the meshes
  int parent = -1;               // index of a node that precedes this one; -1: the scene's root
  std::vector<const aiNode*> parts;
};

// Returns the nodes, parents first. assimp writes an FBX node X that has pivots or pre-rotations as
// a chain of nodes, "X_$AssimpFbx$_Translation" ... X: here it is one node, with the chain as
// parts. Geometric transforms, which apply to meshes only, are no parts. O(nodes), not recursive.
std::vector<SceneNode> SceneNodes(const aiScene& scene);

// Returns the constant rotation that a part of an FBX node applies after its animated rotation
// (its inverse post-rotation), or identity.
Eigen::Matrix3d InversePostRotation(const SceneNode& node);

// Returns the transform of one of assimp's nodes to its parent.
Eigen::Affine3d ToAffine(const aiMatrix4x4& matrix);

// Where a name of an animation channel or a bone leads.
struct NodePlace {
  int node = -1;             // index in SceneNodes
  int part = 0;              // of the node; the last is the node itself
  bool is_repeated = false;  // several nodes have this name: assimp does not tell them apart
};

using NodePlaces = std::unordered_map<std::string_view, NodePlace>;

NodePlaces FindPlaces(const std::vector<SceneNode>& nodes);

// What is known of a node from all takes.
struct NodeUse {
  bool has_channel = false;
  bool moves = false;  // a key of a channel differs from the first one
  bool is_bone = false;
  bool is_view = false;  // camera or light
};

// In the order of `nodes`. O(nodes + keys + bones).
std::vector<NodeUse> UsesOfNodes(const aiScene& scene, const std::vector<SceneNode>& nodes,
                                 const NodePlaces& places);

struct SceneTake {
  std::string name;  // unique in the file, not empty
  const aiAnimation* animation = nullptr;
};

// Returns the takes of the scene, in its order. A take in which no node moves, besides cameras and
// lights, does not count if others move. REQUIRES: the scene has an animation. O(keys).
std::vector<SceneTake> FindTakes(const aiScene& scene, const NodePlaces& places,
                                 const std::vector<NodeUse>& uses);

// Returns the take with the name `wanted`, or else with this number from 1; for an empty text the
// only one. INVALID_ARGUMENT, TAKE_REQUIRED with the JSON array of the names (at most 2 KiB) as
// resource "takes", if `wanted` is missing or names no take. REQUIRES: there is a take.
absl::StatusOr<SceneTake> ChooseTake(std::string_view file_name,
                                     const std::vector<SceneTake>& takes, std::string_view wanted);

}  // namespace motiondb::importer
