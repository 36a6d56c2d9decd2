#include "server/translate/clip_message.h"

#include "motiondb/v1/clip.pb.h"
#include "server/translate/file_format.h"
#include "server/translate/resource_name.h"
#include "server/translate/timestamp.h"
#include "text/utf8.h"

namespace motiondb::server {

void SetClip(const storage::ClipRecord& record, v1::Clip& message) {
  message.set_name(ClipName(record.database, record.id));
  message.set_label(record.label);
  message.set_subject(record.subject);
  message.set_file_name(record.file_name);
  message.set_format(ToProto(record.format));
  message.set_frame_count(record.frame_count);
  message.set_duration_seconds(record.duration_seconds);
  message.set_source_frame_rate_hz(record.source_frame_rate_hz);
  message.set_leg_length_m(record.leg_length_m);
  if (!record.skeleton_id.empty()) {
    message.set_skeleton(SkeletonName(record.database, record.skeleton_id));
  }
  message.set_source_report(text::ValidUtf8(record.source_report));
  SetTimestamp(record.create_time_us, *message.mutable_create_time());
}

void SetSkeleton(const std::string& database, const storage::SkeletonRecord& record,
                 v1::Skeleton& message) {
  message.set_name(SkeletonName(database, record.id));
  message.set_dof_count(record.skeleton.dof_count());
  for (const core::Joint& joint : record.skeleton.joints()) {
    v1::Skeleton::Joint& to = *message.add_joints();
    to.set_name(text::ValidUtf8(joint.name));
    to.set_parent(joint.parent);
    to.set_offset_x_m(joint.offset_m.x());
    to.set_offset_y_m(joint.offset_m.y());
    to.set_offset_z_m(joint.offset_m.z());
    for (const core::Dof& dof : joint.dofs) {
      v1::Skeleton::Dof& to_dof = *to.add_dofs();
      to_dof.set_translation(dof.kind == core::Dof::Kind::kTranslation);
      to_dof.set_axis_x(dof.axis.x());
      to_dof.set_axis_y(dof.axis.y());
      to_dof.set_axis_z(dof.axis.z());
    }
  }
}

}  // namespace motiondb::server
