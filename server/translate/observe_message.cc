#include "server/translate/observe_message.h"

#include <algorithm>

#include "core/motion/error.h"
#include "motiondb/v1/observe.pb.h"
#include "server/translate/frames.h"
#include "server/translate/numbers.h"
#include "server/translate/packed_floats.h"
#include "server/translate/query_message.h"
#include "server/translate/query_options.h"

namespace motiondb::server {

absl::StatusOr<ObserveSetup> SetupFrom(const v1::ObserveStart& start, const core::Model& model,
                                       const core::MarkerSet& set) {
  ObserveSetup setup;
  setup.marker_names.assign(start.marker_names().begin(), start.marker_names().end());
  if (setup.marker_names.empty()) setup.marker_names = set.markers;
  MOTIONDB_RETURN_IF_ERROR(CheckUnique("start.marker_names", setup.marker_names));
  MOTIONDB_ASSIGN_OR_RETURN(setup.frame_rate_hz,
                            Positive("start.frame_rate_hz", start.frame_rate_hz()));
  MOTIONDB_ASSIGN_OR_RETURN(setup.leg_length_m,
                            OptionalPositive("start.leg_length_m", start.leg_length_m()));
  MOTIONDB_ASSIGN_OR_RETURN(setup.options, OptionsFrom("start.", start, model));
  return setup;
}

absl::StatusOr<core::FrameMatrix> FramesFrom(const v1::ObservedFrames& frames,
                                             const std::vector<std::string>& marker_names) {
  const FrameShape shape{frames.frame_count(), 3 * static_cast<int>(marker_names.size())};
  MOTIONDB_ASSIGN_OR_RETURN(core::FrameMatrix positions_m,
                            FramesFrom("frames", "positions", shape, frames.positions()));
  MOTIONDB_RETURN_IF_ERROR(CheckMarkers("frames.positions", marker_names, positions_m));
  return positions_m;
}

void SetStep(const ObserveStep& step, int top_count, v1::ObserveResponse& message) {
  message.set_model_version(step.model_version);
  message.set_model_replaced(step.model_replaced);
  message.set_late_frames(step.late_frames);
  message.set_missing_frames(step.missing_frames);
  if (!step.observed) return;
  const core::Observed& observed = *step.observed;
  message.set_frame(observed.frame);
  message.set_layer(observed.layer);
  SetState(observed.state, *message.mutable_state());
  SetLabels(observed.labels, top_count, *message.mutable_labels());
  message.set_familiarity(observed.familiarity);
  SetHorizons(observed.horizons, *message.mutable_horizons());
}

void SetMarkers(const core::MarkerMotion& motion, v1::MarkerObservation& message) {
  message.mutable_marker_names()->Add(motion.names.begin(), motion.names.end());
  message.set_frame_rate_hz(motion.frame_rate_hz);
  message.set_frame_count(static_cast<int>(motion.positions_m.rows()));
  AppendPacked(motion.positions_m.data(), static_cast<std::size_t>(motion.positions_m.size()),
               *message.mutable_positions());
}

}  // namespace motiondb::server
