#include "core/planning/extrapolation.h"

#include <utility>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/states.h"
#include "core/recognition/recognize.h"

namespace motiondb::core {

absl::Status MeasureExtrapolation(const Model& model, const MarkerSet& set,
                                  std::shared_ptr<const ClipMask> mask, double leg_length_m,
                                  const Cancelled& cancelled, PlannedMotion& motion) {
  if (!model.recognition().window.unknown || motion.markers.positions_m.rows() < 2) {
    return absl::OkStatus();
  }
  MOTIONDB_ASSIGN_OR_RETURN(const MarkerMotion resampled,
                            Resample(motion.markers, model.settings().frame_rate_hz));
  MOTIONDB_ASSIGN_OR_RETURN(const StateSequence states,
                            ComputeStates(set, resampled, leg_length_m));
  RecognizeOptions options;
  options.mask = std::move(mask);
  MOTIONDB_ASSIGN_OR_RETURN(const auto windows, Recognize(model, states, options, cancelled));
  for (const RecognizedWindow& window : windows) {
    if (!window.unknown_probability) continue;
    if (motion.quality.unknown &&
        *window.unknown_probability <= motion.quality.unknown->probability) {
      continue;
    }
    motion.quality.unknown =
        UnlikeStored{*window.unknown_probability, (window.start_seconds + window.end_seconds) / 2};
  }
  return absl::OkStatus();
}

}  // namespace motiondb::core
