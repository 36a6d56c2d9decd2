// Parts of a GLB file (glTF 2.0): bytes of its buffer and the JSON that describes them; and a mesh
// that makes a skeleton visible in 3D viewers: an octahedron for each bone, skinned to its joints.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/motion/motion.h"

namespace motiondb::core {

inline constexpr std::size_t kMaxGlbBytes = std::numeric_limits<std::uint32_t>::max();

// Values of glTF 2.0.
enum class GlbComponent { kUnsignedShort = 5123, kFloat = 5126 };
enum class GlbTarget { kNone = 0, kVertices = 34962, kVertexIndices = 34963 };

// Describes the buffer in the JSON chunk, in the order in which it is written.
class GlbLayout {
 public:
  // Adds a buffer view after the previous one. REQUIRES: the size is a multiple of 4.
  void AddView(std::size_t bytes, GlbTarget target);

  // Adds an accessor to the last view, after its other ones, and returns its index. `bytes`: of one
  // element. REQUIRES: AddView was called; the accessors fit the view.
  std::size_t AddAccessor(std::string_view type, GlbComponent component, std::size_t count,
                          std::size_t bytes);
  void SetBounds(std::size_t accessor, nlohmann::ordered_json least, nlohmann::ordered_json most);

  // Bytes of the buffer.
  std::size_t size() const { return size_; }

  // Moves "accessors", "bufferViews" and "buffers" to the document.
  void MoveTo(nlohmann::ordered_json& document);

 private:
  nlohmann::ordered_json accessors_ = nlohmann::ordered_json::array();
  nlohmann::ordered_json views_ = nlohmann::ordered_json::array();
  std::size_t size_ = 0;
  std::size_t offset_ = 0;  // in the last view
};

// Returns the size of the file.
std::size_t GlbSize(std::string_view json, const GlbLayout& layout);

// Returns the file up to the contents of the buffer, with memory reserved for them. REQUIRES:
// GlbSize() <= kMaxGlbBytes.
std::string BeginGlb(std::string_view json, const GlbLayout& layout);

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
