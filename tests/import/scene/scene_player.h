// Evaluates a scene as a player does: a product of assimp's matrices down its tree of nodes.
#pragma once

#include <assimp/scene.h>

#include <Eigen/Core>
#include <map>
#include <string>

namespace motiondb::tests {

class ScenePlayer {
 public:
  // `scene` must outlive this object and have this animation.
  ScenePlayer(const aiScene& scene, unsigned animation);

  // The first time (ticks) of the channels that have several keys, but at least 0.
  double FirstTick() const;
  double TicksPerSecond() const { return animation_.mTicksPerSecond; }

  // Positions of the nodes, by name, in the scene's axes and unit.
  std::map<std::string, Eigen::Vector3d> At(double ticks) const;

 private:
  aiMatrix4x4 Local(const aiNode& node, double ticks) const;
  void Visit(const aiNode& node, const aiMatrix4x4& above, double ticks,
             std::map<std::string, Eigen::Vector3d>& positions) const;

  const aiScene& scene_;
  const aiAnimation& animation_;
  std::map<std::string, const aiNodeAnim*> channels_;
};

}  // namespace motiondb::tests
