// A mesh that makes a skeleton visible in 3D viewers: an octahedron for each bone, skinned to its
// joints.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "core/motion/skeleton.h"

namespace motiondb::core {

struct BoneMesh {
  struct Vertex {
    Eigen::Vector3f position;  // in the rest pose, m
    std::uint16_t joint = 0;   // that it follows
  };
  std::vector<Vertex> vertices;
  std::vector<std::uint16_t> indices;  // three a triangle, counter-clockwise seen from outside
};

// Returns octahedra from each joint to its children, without bones shorter than 1 mm. Their tips
// follow the children. Roots and sliding joints without any bone, such as markers, get one of 2 cm
// radius. `rest`: poses of all joints. REQUIRES: 1 to 10000 joints.
BoneMesh MakeBoneMesh(std::span<const Joint> joints, std::span<const Eigen::Isometry3d> rest);

}  // namespace motiondb::core
