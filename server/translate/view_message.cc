#include "server/translate/view_message.h"

#include "core/model/model.h"
#include "core/view/node_summary.h"
#include "core/view/state_axes.h"
#include "motiondb/v1/model.pb.h"
#include "motiondb/v1/view.pb.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

void AppendRow(const core::FrameMatrix& rows, int row, std::string& bytes) {
  AppendPacked(rows.row(row).data(), static_cast<std::size_t>(rows.cols()), bytes);
}

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

void SetMapHeader(const Snapshot& snapshot, const core::StateAxes& axes, int layer,
                  v1::StateMapHeader& message) {
  const core::Model& model = snapshot.model;
  message.set_model_version(snapshot.record.version);
  message.set_layer(layer);
  for (int l = 1; l <= model.layer_count(); ++l) {
    message.add_nodes_per_layer(model.tree().node_count(l));
  }
  for (const double fraction : axes.variance_fractions) message.add_variance_fractions(fraction);
  for (const core::ModelClip& clip : model.clips()) {
    message.add_clips(ClipName(snapshot.record.database, clip.id));
    message.add_labels(clip.label());
  }
}

void AddNodes(const core::Model& model, core::NodeSummaries& summaries, int layer,
              std::span<const int> nodes, v1::StateMapNodes& message) {
  for (const int node : nodes) {
    const core::NodeSummary summary = summaries.Summarize(layer, node);
    message.add_node_ids(node);
    if (layer > 1) message.add_parent_ids(model.tree().parent(layer, node));
    message.add_frame_counts(summary.frame_count);
    message.add_main_clips(summary.main_clip);
    message.add_label_fractions(summary.label_fraction);
    AppendMatrix(summary.mean, *message.mutable_means());
    AppendMatrix(summary.semi_axes, *message.mutable_semi_axes());
  }
}

void AddTransitions(const TransitionList& transitions, int first, int end,
                    v1::StateMapTransitions& message) {
  v1::Transition transition;
  for (int i = first; i < end; ++i) {
    transitions.SetTransition(i, transition);
    message.add_from_node_ids(transition.from_node_id());
    message.add_to_node_ids(transition.to_node_id());
    message.add_probabilities(static_cast<float>(transition.probability()));
  }
}

void AddPoints(const core::Model& model, const core::StateAxes& axes, int layer,
               std::span<const int> frames, v1::StateMapPoints& message) {
  for (const int frame : frames) {
    const int clip = model.clip_of_frame(frame);
    message.add_clips(clip);
    message.add_frames(frame - model.clips()[clip].first_frame);
    message.add_node_ids(model.tree().node_of_frame(layer, frame));
    AppendRow(axes.projections, frame, *message.mutable_positions());
  }
}

void SetNodePose(int node, const core::MeanPose& pose, v1::NodePose& message) {
  message.set_node_id(node);
  AppendMatrix(pose.positions_m, *message.mutable_marker_positions());
  AppendMatrix(pose.velocities_m_s, *message.mutable_marker_velocities());
}

}  // namespace motiondb::server
