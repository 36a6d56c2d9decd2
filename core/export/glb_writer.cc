#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/export/file_bytes.h"
#include "core/export/glb_parts.h"
#include "core/export/writers.h"
#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

using GlbJson = nlohmann::ordered_json;

constexpr double kMaxGlbDistance_m = 1e18;  // its square fits single precision

bool HasDofOfKind(const Joint& joint, Dof::Kind kind) {
  return std::any_of(joint.dofs.begin(), joint.dofs.end(),
                     [&](const Dof& dof) { return dof.kind == kind; });
}

// The keys of one joint.
struct GlbChannel {
  int joint = 0;
  bool rotates = false;  // else it translates
};

GlbJson GlbNumbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  GlbJson numbers = GlbJson::array();
  for (const double value : values) numbers.push_back(value);
  return numbers;
}

// Roots are written with y up, all other joints in their parents' frames.
class GlbWriter {
 public:
  explicit GlbWriter(const JointMotion& motion)
      : motion_(motion),
        joints_(motion.skeleton->joints()),
        file_from_world_(WorldFromFile(UpAxis::kY).transpose()),
        frames_(static_cast<std::size_t>(motion.angles.rows())) {
    for (int j = 0; j < motion.skeleton->joint_count(); ++j) {
      if (HasDofOfKind(joints_[j], Dof::Kind::kRotation)) channels_.push_back({j, true});
      // A root without translations gets keys too: an animation must not be empty.
      if (joints_[j].parent < 0 || HasDofOfKind(joints_[j], Dof::Kind::kTranslation)) {
        channels_.push_back({j, false});
      }
    }
    std::stable_partition(channels_.begin(), channels_.end(),
                          [](const GlbChannel& channel) { return channel.rotates; });
  }

  absl::StatusOr<std::string> Write() {
    MOTIONDB_RETURN_IF_ERROR(CheckTimes());
    MOTIONDB_RETURN_IF_ERROR(SetRestPose());
    const std::string text = Describe();
    const std::size_t length = GlbSize(text, layout_);
    if (length > kMaxGlbBytes) {
      return InvalidArgument("GLB: expected at most 4 GiB, {} frames need {} bytes", frames_,
                             length);
    }
    bytes_ = BeginGlb(text, layout_);
    for (std::size_t frame = 0; frame < frames_; ++frame) AppendReal(TimeOf(frame), bytes_);
    for (const GlbChannel& channel : channels_) MOTIONDB_RETURN_IF_ERROR(WriteKeys(channel));
    for (const Eigen::Isometry3d& pose : rest_) Append(pose.inverse().matrix().reshaped());
    WriteMesh();
    return std::move(bytes_);
  }

 private:
  void Append(const Eigen::Ref<const Eigen::VectorXd>& values) {
    for (const double value : values) AppendReal(static_cast<float>(value), bytes_);
  }

  float TimeOf(std::size_t frame) const {
    return static_cast<float>(static_cast<double>(frame) / motion_.frame_rate_hz);
  }

  absl::Status CheckTimes() const {
    for (std::size_t frame = 1; frame < frames_; ++frame) {
      if (TimeOf(frame) > TimeOf(frame - 1)) continue;
      return InvalidArgument(
          "GLB: frames {} and {} have the same time in single precision: expected a shorter motion "
          "at {} Hz",
          frame - 1, frame, motion_.frame_rate_hz);
    }
    return absl::OkStatus();
  }

  // Returns the joint's transform to its parent's frame, or a root's to the file's.
  Eigen::Isometry3d Local(int j, std::span<const double> angles) const {
    const Joint& joint = joints_[j];
    const Eigen::Isometry3d local = ParentFromJoint(
        joint, angles.subspan(static_cast<std::size_t>(motion_.skeleton->first_dof(j)),
                              joint.dofs.size()));
    return joint.parent < 0 ? Eigen::Isometry3d(file_from_world_) * local : local;
  }

  absl::Status SetRestPose() {
    const std::vector<double> zeros(static_cast<std::size_t>(motion_.skeleton->dof_count()));
    for (int j = 0; j < motion_.skeleton->joint_count(); ++j) {
      const Eigen::Isometry3d local = Local(j, zeros);
      MOTIONDB_RETURN_IF_ERROR(CheckDistance(j, "at rest", local));
      // The pose of the node, whose rotation is a unit quaternion.
      const Eigen::Isometry3d node = Eigen::Translation3d(local.translation()) *
                                     Eigen::Quaterniond(local.linear()).normalized();
      rest_locals_.push_back(node);
      rest_.push_back(joints_[j].parent < 0 ? node : rest_[joints_[j].parent] * node);
    }
    mesh_ = MakeBoneMesh(joints_, rest_);
    return absl::OkStatus();
  }

  absl::Status CheckDistance(int j, std::string_view when, const Eigen::Isometry3d& local) const {
    if (local.translation().cwiseAbs().maxCoeff() <= kMaxGlbDistance_m) return absl::OkStatus();
    return InvalidArgument("GLB: joint '{}' is {} m from its parent {}: expected at most {} m",
                           Shown(joints_[j].name), local.translation().cwiseAbs().maxCoeff(), when,
                           kMaxGlbDistance_m);
  }

  // Returns the JSON chunk.
  std::string Describe() {
    GlbJson animation = DescribeAnimation();
    layout_.AddView(64 * joints_.size(), GlbTarget::kNone);
    const std::size_t inverse_binds =
        layout_.AddAccessor("MAT4", GlbComponent::kFloat, joints_.size(), 64);
    GlbJson mesh = DescribeMesh();
    const std::size_t mesh_node = joints_.size();
    UniqueNames names;
    GlbJson nodes = DescribeNodes(names);
    nodes.push_back({{"name", names.Add("figure")}, {"mesh", 0}, {"skin", 0}});
    GlbJson roots = GlbJson::array();
    GlbJson bones = GlbJson::array();
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      bones.push_back(j);
      if (joints_[j].parent < 0) roots.push_back(j);
    }
    if (roots.size() > 1) {  // the joints of a skin must have a common ancestor
      nodes.push_back({{"name", names.Add("roots")}, {"children", std::move(roots)}});
      roots = GlbJson::array({mesh_node + 1});
    }
    roots.push_back(mesh_node);
    GlbJson document = {
        {"asset",
         {{"version", "2.0"},
          {"generator", "motiondb"},
          {"extras", {{"frame_rate_hz", motion_.frame_rate_hz}}}}},
        {"scene", 0},
        {"scenes", GlbJson::array({{{"nodes", std::move(roots)}}})},
        {"nodes", std::move(nodes)},
        {"meshes", GlbJson::array({std::move(mesh)})},
        {"materials",
         GlbJson::array({{{"pbrMetallicRoughness",
                           {{"baseColorFactor", {0.6, 0.7, 0.8, 1}}, {"metallicFactor", 0}}}}})},
        {"skins",
         GlbJson::array({{{"inverseBindMatrices", inverse_binds}, {"joints", std::move(bones)}}})},
        {"animations", GlbJson::array({std::move(animation)})}};
    layout_.MoveTo(document);
    return document.dump(-1, ' ', false, GlbJson::error_handler_t::replace);
  }

  GlbJson DescribeAnimation() {
    layout_.AddView(4 * frames_, GlbTarget::kNone);
    const std::size_t times = layout_.AddAccessor("SCALAR", GlbComponent::kFloat, frames_, 4);
    layout_.SetBounds(times, GlbJson::array({0}), GlbJson::array({TimeOf(frames_ - 1)}));
    GlbJson channels = GlbJson::array();
    GlbJson samplers = GlbJson::array();
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      const bool rotates = channels_[c].rotates;
      const std::size_t key = rotates ? 16 : 12;  // bytes
      if (c == 0 || rotates != channels_[c - 1].rotates) {
        const auto same =
            std::count_if(channels_.begin(), channels_.end(),
                          [&](const GlbChannel& channel) { return channel.rotates == rotates; });
        layout_.AddView(key * frames_ * static_cast<std::size_t>(same), GlbTarget::kNone);
      }
      const std::size_t keys =
          layout_.AddAccessor(rotates ? "VEC4" : "VEC3", GlbComponent::kFloat, frames_, key);
      samplers.push_back({{"input", times}, {"output", keys}});  // LINEAR is the default
      channels.push_back(
          {{"sampler", c},
           {"target",
            {{"node", channels_[c].joint}, {"path", rotates ? "rotation" : "translation"}}}});
    }
    return {
        {"name", "motion"}, {"channels", std::move(channels)}, {"samplers", std::move(samplers)}};
  }

  GlbJson DescribeMesh() {
    const std::size_t vertices = mesh_.vertices.size();
    layout_.AddView(12 * vertices, GlbTarget::kVertices);
    const std::size_t positions = layout_.AddAccessor("VEC3", GlbComponent::kFloat, vertices, 12);
    Eigen::Vector3f least = mesh_.vertices.front().position;
    Eigen::Vector3f most = least;
    for (const BoneMesh::Vertex& vertex : mesh_.vertices) {
      least = least.cwiseMin(vertex.position);
      most = most.cwiseMax(vertex.position);
    }
    layout_.SetBounds(positions, GlbNumbers(least.cast<double>()), GlbNumbers(most.cast<double>()));
    layout_.AddView(8 * vertices, GlbTarget::kVertices);
    const std::size_t bones =
        layout_.AddAccessor("VEC4", GlbComponent::kUnsignedShort, vertices, 8);
    layout_.AddView(16 * vertices, GlbTarget::kVertices);
    const std::size_t weights = layout_.AddAccessor("VEC4", GlbComponent::kFloat, vertices, 16);
    layout_.AddView(2 * mesh_.indices.size(), GlbTarget::kVertexIndices);
    const std::size_t indices =
        layout_.AddAccessor("SCALAR", GlbComponent::kUnsignedShort, mesh_.indices.size(), 2);
    // Without normals, viewers shade the triangles flat.
    return {
        {"primitives",
         GlbJson::array({{{"attributes",
                           {{"POSITION", positions}, {"JOINTS_0", bones}, {"WEIGHTS_0", weights}}},
                          {"indices", indices},
                          {"material", 0}}})}};
  }

  GlbJson DescribeNodes(UniqueNames& names) const {
    GlbJson nodes = GlbJson::array();
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const Eigen::Quaterniond rotation(rest_locals_[j].linear());
      nodes.push_back({{"name", names.Add(joints_[j].name)},
                       {"translation", GlbNumbers(rest_locals_[j].translation())},
                       {"rotation", GlbNumbers(rotation.coeffs())}});
      if (joints_[j].parent >= 0) {
        nodes[static_cast<std::size_t>(joints_[j].parent)]["children"].push_back(j);
      }
    }
    return nodes;
  }

  absl::Status WriteKeys(const GlbChannel& channel) {
    const std::size_t dofs = static_cast<std::size_t>(motion_.angles.cols());
    Eigen::Quaterniond previous = Eigen::Quaterniond::Identity();
    for (std::size_t frame = 0; frame < frames_; ++frame) {
      const Eigen::Isometry3d local =
          Local(channel.joint, {motion_.angles.data() + frame * dofs, dofs});
      if (!channel.rotates) {
        MOTIONDB_RETURN_IF_ERROR(
            CheckDistance(channel.joint, fmt::format("in frame {}", frame), local));
        Append(local.translation());
        continue;
      }
      Eigen::Quaterniond rotation = Eigen::Quaterniond(local.linear()).normalized();
      if (rotation.dot(previous) < 0) rotation.coeffs() *= -1;
      Append(rotation.coeffs());  // x, y, z, w
      previous = rotation;
    }
    return absl::OkStatus();
  }

  void WriteMesh() {
    for (const BoneMesh::Vertex& vertex : mesh_.vertices) {
      Append(vertex.position.cast<double>());
    }
    for (const BoneMesh::Vertex& vertex : mesh_.vertices) {
      AppendWord16(vertex.joint, bytes_);
      for (int unused = 0; unused < 3; ++unused) AppendWord16(0, bytes_);
    }
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) Append(Eigen::Vector4d::UnitX());
    for (const std::uint16_t index : mesh_.indices) AppendWord16(index, bytes_);
  }

  const JointMotion& motion_;
  const std::vector<Joint>& joints_;
  Eigen::Matrix3d file_from_world_;
  std::size_t frames_;
  std::vector<GlbChannel> channels_;            // rotations first
  std::vector<Eigen::Isometry3d> rest_locals_;  // of the nodes, in their parents' frames
  std::vector<Eigen::Isometry3d> rest_;         // in the file's frame
  BoneMesh mesh_;
  GlbLayout layout_;
  std::string bytes_;
};

}  // namespace

std::vector<std::string> GlbNames(const Skeleton& skeleton) {
  UniqueNames unique;
  std::vector<std::string> names;
  for (const Joint& joint : skeleton.joints()) names.push_back(unique.Add(joint.name));
  return names;
}

absl::StatusOr<std::string> WriteGlb(const JointMotion& motion) {
  MOTIONDB_RETURN_IF_ERROR(CheckWritable("GLB", motion));
  if (motion.skeleton->joint_count() > kMaxFileJoints) {
    return InvalidArgument("GLB: expected at most {} joints, found {}", kMaxFileJoints,
                           motion.skeleton->joint_count());
  }
  return GlbWriter(motion).Write();
}

}  // namespace motiondb::core
