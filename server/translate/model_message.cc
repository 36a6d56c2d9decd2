#include "server/translate/model_message.h"

#include "core/model/model.h"
#include "motiondb/v1/model.pb.h"
#include "motiondb/v1/view.pb.h"
#include "server/engine/snapshot.h"
#include "server/translate/message_fields.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

void AppendRow(const core::FrameMatrix& rows, int row, std::string& bytes) {
  AppendPacked(rows.row(row).data(), static_cast<std::size_t>(rows.cols()), bytes);
}

}  // namespace

void SetModel(const storage::ModelRecord& record, const core::BuildSettings& settings,
              const Snapshot* snapshot, v1::Model& message) {
  // A model that is not stored has the version of an earlier model, but its own time.
  const bool current = snapshot != nullptr && snapshot->record.version == record.version &&
                       snapshot->record.create_time_us == record.create_time_us;
  const Calibration calibration = current ? snapshot->calibration : Calibration::kOwn;
  message.set_name(calibration == Calibration::kOwn ? ModelName(record.database, record.version)
                                                    : CurrentModelName(record.database));
  message.set_calibration(current ? CalibrationOf(*snapshot) : v1::CALIBRATION_OWN);
  message.set_version(record.version);
  message.set_state(current ? v1::MODEL_STATE_CURRENT : v1::MODEL_STATE_SUPERSEDED);
  SetTimestamp(record.create_time_us, *message.mutable_create_time());
  SetModelStatistics(record, message);
  message.set_added_frame_count(record.added_frame_count);
  message.set_scaling(ToProto(settings.scaling));
  if (!current) return;
  const auto& divisor = snapshot->model.scale().divisor;
  AppendPacked(divisor.data(), static_cast<std::size_t>(divisor.size()), *message.mutable_scales());
  for (const core::ModelClip& clip : snapshot->model.clips()) {
    message.add_clips(ClipName(record.database, clip.id));
    message.add_first_frames(clip.first_frame);
  }
}

void SetNode(const core::Model& model, int layer, int node, v1::Node& message) {
  const int index = model.tree().branch(layer, node);
  const core::Branch& branch = model.tree().branches()[index];
  const core::NodeGaussians& gaussians = model.gaussians();
  message.set_node_id(node);
  if (layer > 1) message.set_parent_id(model.tree().parent(layer, node));
  message.set_frame_count(branch.end - branch.begin);
  AppendRow(gaussians.means(), index, *message.mutable_mean());
  AppendRow(gaussians.variances(), index, *message.mutable_variance());
}

void SetStates(const core::Model& model, int first_frame, int end_frame,
               v1::ReadStatesResponse& message) {
  message.set_first_frame(first_frame);
  message.set_frame_count(end_frame - first_frame);
  const auto states = model.states();
  AppendPacked(states.row(first_frame).data(),
               static_cast<std::size_t>((end_frame - first_frame) * states.cols()),
               *message.mutable_states());
  for (int frame = first_frame; frame < end_frame; ++frame) {
    message.add_bottom_node_ids(model.tree().node_of_frame(model.layer_count(), frame));
  }
}

void SetTransition(const Transition& transition, v1::Transition& message) {
  message.set_from_node_id(transition.from);
  message.set_to_node_id(transition.to);
  message.set_count(transition.count);
  message.set_probability(transition.probability);
}

namespace {

v1::VisualGeometry ToProto(core::LinkVisual::Geometry geometry) {
  switch (geometry) {
    case core::LinkVisual::Geometry::kBox:
      return v1::VISUAL_GEOMETRY_BOX;
    case core::LinkVisual::Geometry::kCylinder:
      return v1::VISUAL_GEOMETRY_CYLINDER;
    case core::LinkVisual::Geometry::kSphere:
      return v1::VISUAL_GEOMETRY_SPHERE;
  }
  return v1::VISUAL_GEOMETRY_UNSPECIFIED;
}

template <typename Vector>
void AddFloats(const Vector& values, google::protobuf::RepeatedField<float>& message) {
  for (const double value : values) message.Add(static_cast<float>(value));
}

template <typename Matrix>
void AppendMatrix(const Matrix& values, std::string& bytes) {
  AppendPacked(values.data(), static_cast<std::size_t>(values.size()), bytes);
}

}  // namespace

void AddBones(std::span<const core::BoneEnds> bones,
              google::protobuf::RepeatedPtrField<v1::Bone>& messages) {
  for (const auto& [from, to] : bones) {
    v1::Bone& bone = *messages.Add();
    bone.set_from_point(from);
    bone.set_to_point(to);
  }
}

void AddVisuals(std::span<const core::LinkVisual> visuals,
                google::protobuf::RepeatedPtrField<v1::LinkVisual>& messages) {
  for (const core::LinkVisual& visual : visuals) {
    v1::LinkVisual& message = *messages.Add();
    message.set_joint(visual.joint);
    message.set_geometry(ToProto(visual.geometry));
    AddFloats(visual.size_m, *message.mutable_size_m());
    AddFloats(Eigen::Vector3d(visual.joint_from_shape.translation()),
              *message.mutable_position_m());
    AddFloats(Eigen::Quaterniond(visual.joint_from_shape.linear()).coeffs(),
              *message.mutable_rotation());
    if (visual.color) AddFloats(*visual.color, *message.mutable_color());
  }
}

void SetFigure(const Figure& figure, v1::Figure& message) {
  for (const std::string& name : figure.marker_names) {
    message.add_marker_names(text::ValidUtf8(name));
  }
  AddBones(figure.marker_bones, *message.mutable_marker_bones());
  for (const std::string& name : figure.joint_names) {
    message.add_joint_names(text::ValidUtf8(name));
  }
  AddBones(figure.joint_bones, *message.mutable_joint_bones());
  AddVisuals(figure.joint_visuals, *message.mutable_joint_visuals());
}

void SetClipFrames(const ClipMotion& motion, int first_frame, int count, int stride,
                   v1::ReadClipMotionResponse& message) {
  message.set_first_frame(first_frame);
  message.set_frame_count(count);
  for (int i = 0; i < count; ++i) {
    const int frame = first_frame + i * stride;
    AppendRow(motion.markers_m, frame, *message.mutable_marker_positions());
    if (motion.joints_m.rows() > 0) {
      AppendRow(motion.joints_m, frame, *message.mutable_joint_positions());
    }
    if (motion.joint_rotations.rows() > 0) {
      AppendRow(motion.joint_rotations, frame, *message.mutable_joint_rotations());
    }
    if (!motion.contacts.empty()) {
      message.mutable_contacts()->push_back(static_cast<char>(motion.contacts[frame]));
    }
  }
}

void SetMapHeader(const StateMap& map, v1::StateMapHeader& message) {
  const core::Model& model = map.model();
  const storage::ModelRecord& record = map.snapshot().record;
  message.set_model_version(map.model_version());
  message.set_layer(map.layer());
  for (int l = 1; l <= model.layer_count(); ++l) {
    message.add_nodes_per_layer(model.tree().node_count(l));
  }
  for (const double fraction : map.axes().variance_fractions) {
    message.add_variance_fractions(fraction);
  }
  for (const core::ModelClip& clip : model.clips()) {
    message.add_clips(ClipName(record.database, clip.id));
    message.add_labels(clip.label());
  }
  message.set_node_count(map.node_count());
  message.set_transition_count(map.transitions().edge_count());
  message.set_point_count(map.point_count());
}

void AddNodes(StateMap& map, std::span<const int> nodes, v1::StateMapNodes& message) {
  for (const int node : nodes) {
    const core::NodeSummary summary = map.Summarize(node);
    message.add_node_ids(node);
    if (map.layer() > 1) message.add_parent_ids(map.model().tree().parent(map.layer(), node));
    message.add_frame_counts(summary.frame_count);
    message.add_main_clips(summary.main_clip);
    message.add_label_fractions(summary.label_fraction);
    AppendMatrix(summary.mean, *message.mutable_means());
    AppendMatrix(summary.semi_axes, *message.mutable_semi_axes());
  }
}

void AddTransitions(const StateMap& map, int first, int end, v1::StateMapTransitions& message) {
  for (int i = first; i < end; ++i) {
    const Transition transition = map.transitions().At(i);
    message.add_from_node_ids(transition.from);
    message.add_to_node_ids(transition.to);
    message.add_probabilities(static_cast<float>(transition.probability));
  }
}

void AddPoints(const StateMap& map, std::span<const int> frames, v1::StateMapPoints& message) {
  const core::Model& model = map.model();
  for (const int frame : frames) {
    const int clip = model.clip_of_frame(frame);
    message.add_clips(clip);
    message.add_frames(frame - model.clips()[clip].first_frame);
    message.add_node_ids(model.tree().node_of_frame(map.layer(), frame));
    AppendRow(map.axes().projections, frame, *message.mutable_positions());
  }
}

void SetNodePoses(const NodePoses& poses, v1::GetNodePosesResponse& message) {
  message.set_layer(poses.layer);
  for (const NodePose& from : poses.poses) {
    v1::NodePose& to = *message.add_poses();
    to.set_node_id(from.node);
    AppendMatrix(from.pose.positions_m, *to.mutable_marker_positions());
    AppendMatrix(from.pose.velocities_m_s, *to.mutable_marker_velocities());
  }
}

}  // namespace motiondb::server
