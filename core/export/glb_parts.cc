#include "core/export/glb_parts.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/export/file_bytes.h"

namespace motiondb::core {
namespace {

constexpr std::size_t kGlbMagic = 0x46546C67;  // "glTF"
constexpr std::size_t kGlbVersion = 2;
constexpr std::size_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr std::size_t kBufferChunk = 0x004E4942;  // "BIN"
constexpr std::size_t kFileHeader = 12;           // bytes
constexpr std::size_t kChunkHeader = 8;

// Chunks start at multiples of 4 bytes.
std::size_t Aligned(std::size_t size) { return (size + 3) / 4 * 4; }

}  // namespace

void GlbLayout::AddView(std::size_t bytes, GlbTarget target) {
  nlohmann::ordered_json view = {{"buffer", 0}, {"byteOffset", size_}, {"byteLength", bytes}};
  if (target != GlbTarget::kNone) view["target"] = static_cast<int>(target);
  views_.push_back(std::move(view));
  offset_ = 0;
  size_ += bytes;
}

std::size_t GlbLayout::AddAccessor(std::string_view type, GlbComponent component, std::size_t count,
                                   std::size_t bytes) {
  accessors_.push_back({{"bufferView", views_.size() - 1},
                        {"byteOffset", offset_},
                        {"componentType", static_cast<int>(component)},
                        {"count", count},
                        {"type", type}});
  offset_ += count * bytes;
  return accessors_.size() - 1;
}

void GlbLayout::SetBounds(std::size_t accessor, nlohmann::ordered_json least,
                          nlohmann::ordered_json most) {
  accessors_[accessor]["min"] = std::move(least);
  accessors_[accessor]["max"] = std::move(most);
}

void GlbLayout::MoveTo(nlohmann::ordered_json& document) {
  document["accessors"] = std::move(accessors_);
  document["bufferViews"] = std::move(views_);
  document["buffers"] = nlohmann::ordered_json::array({{{"byteLength", size_}}});
}

std::size_t GlbSize(std::string_view json, const GlbLayout& layout) {
  return kFileHeader + 2 * kChunkHeader + Aligned(json.size()) + layout.size();
}

std::string BeginGlb(std::string_view json, const GlbLayout& layout) {
  std::string bytes;
  bytes.reserve(GlbSize(json, layout));
  const auto append = [&](std::size_t word) {
    AppendWord32(static_cast<std::uint32_t>(word), bytes);
  };
  append(kGlbMagic);
  append(kGlbVersion);
  append(GlbSize(json, layout));
  append(Aligned(json.size()));
  append(kJsonChunk);
  bytes += json;
  bytes.append(Aligned(json.size()) - json.size(), ' ');
  append(layout.size());
  append(kBufferChunk);
  return bytes;
}

namespace {

constexpr double kMinBone_m = 0.001;
constexpr double kPointRadius_m = 0.02;
constexpr int kWaistCorners = 4;

// Of a bone, relative to its length: position along it and radius.
constexpr double kBoneWaist = 0.15;
constexpr double kBoneRadius = 0.08;

struct BoneEnd {
  Eigen::Vector3d position;
  std::size_t joint = 0;
};

void AddOctahedron(const BoneEnd& base, const BoneEnd& tip, double waist, double radius,
                   BoneMesh& mesh) {
  const Eigen::Vector3d bone = tip.position - base.position;
  const Eigen::Vector3d side = radius * bone.unitOrthogonal();
  const Eigen::Vector3d other = bone.normalized().cross(side);
  const Eigen::Vector3d middle = base.position + waist * bone;
  const std::size_t first = mesh.vertices.size();
  const auto add_vertex = [&](const Eigen::Vector3d& position, std::size_t joint) {
    mesh.vertices.push_back({position.cast<float>(), static_cast<std::uint16_t>(joint)});
  };
  add_vertex(base.position, base.joint);
  add_vertex(middle + side, base.joint);
  add_vertex(middle + other, base.joint);
  add_vertex(middle - side, base.joint);
  add_vertex(middle - other, base.joint);
  add_vertex(tip.position, tip.joint);
  for (int corner = 0; corner < kWaistCorners; ++corner) {
    const int a = 1 + corner;
    const int b = 1 + (corner + 1) % kWaistCorners;
    for (const int vertex : {a, b, 1 + kWaistCorners, b, a, 0}) {
      mesh.indices.push_back(static_cast<std::uint16_t>(first + static_cast<std::size_t>(vertex)));
    }
  }
}

// Whether the joint moves by itself, so that it needs a shape even if no bone leads to it.
bool IsFreePoint(const Joint& joint) {
  return joint.parent < 0 || std::any_of(joint.dofs.begin(), joint.dofs.end(), [](const Dof& dof) {
           return dof.kind == Dof::Kind::kTranslation;
         });
}

}  // namespace

BoneMesh MakeBoneMesh(std::span<const Joint> joints, std::span<const Eigen::Isometry3d> rest) {
  BoneMesh mesh;
  std::vector<bool> has_bone(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(joints[j].parent);
    const BoneEnd base = {rest[parent].translation(), parent};
    const BoneEnd tip = {rest[j].translation(), j};
    const double length = (tip.position - base.position).norm();
    if (length < kMinBone_m) continue;
    AddOctahedron(base, tip, kBoneWaist, kBoneRadius * length, mesh);
    has_bone[parent] = has_bone[j] = true;
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (has_bone[j] || !IsFreePoint(joints[j])) continue;
    const Eigen::Vector3d centre = rest[j].translation();
    const Eigen::Vector3d up = {0, kPointRadius_m, 0};
    AddOctahedron({centre - up, j}, {centre + up, j}, 0.5, kPointRadius_m, mesh);
  }
  return mesh;
}

}  // namespace motiondb::core
