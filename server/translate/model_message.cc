#include "server/translate/model_message.h"

#include "core/model/model.h"
#include "motiondb/v1/model.pb.h"
#include "server/engine/query/model_query.h"
#include "server/engine/snapshot.h"
#include "server/translate/message_fields.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {

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
  const auto dimensions = static_cast<std::size_t>(gaussians.dimension_count());
  AppendPacked(gaussians.means().row(index).data(), dimensions, *message.mutable_mean());
  AppendPacked(gaussians.variances().row(index).data(), dimensions, *message.mutable_variance());
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

}  // namespace motiondb::server
