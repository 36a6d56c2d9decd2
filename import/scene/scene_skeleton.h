// Chooses the joints of a scene.
#pragma once

#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "import/scene/scene_nodes.h"

namespace motiondb::importer {

struct SceneJoint {
  std::string name;  // unique, not empty
  int node = -1;     // index in SceneNodes
  int parent = -1;   // index of a joint that precedes this one; -1: the root
};

struct SceneSkeleton {
  std::vector<SceneJoint> joints;  // a tree; joint 0 is its root
  // Product of the transforms of the nodes above the root, which do not move.
  Eigen::Affine3d scene_from_root_parent = Eigen::Affine3d::Identity();
};

// Joints are:
// - nodes with an animation channel in any take and bones of meshes, but of cameras, lights and
//   nodes with meshes only those that move;
// - all nodes besides cameras and lights, if the scene has no mesh;
// - nodes between these, up to their common root. A root that is no bone, does not move and has
//   one child only is left out, unless nothing moves;
// - nodes below a joint without mesh, camera or light: end sites.
// `notes` gets names that were made distinct.
//
// INVALID_ARGUMENT, with the numbers of meshes and nodes, if there is no joint, and if there are
// more than core::kMaxFileJoints. O(nodes).
absl::StatusOr<SceneSkeleton> FindSkeleton(std::string_view file_name, const aiScene& scene,
                                           const std::vector<SceneNode>& nodes,
                                           const std::vector<NodeUse>& uses,
                                           std::vector<std::string>& notes);

// Returns "1 mesh, 23 nodes".
std::string SceneContent(const aiScene& scene, const std::vector<SceneNode>& nodes);

}  // namespace motiondb::importer
