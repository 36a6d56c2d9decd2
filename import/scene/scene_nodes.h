// The nodes of a scene as a flat list.
#pragma once

#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <vector>

namespace motiondb::importer {

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

}  // namespace motiondb::importer
