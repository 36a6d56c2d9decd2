#include "core/planning/stored_floor.h"

#include <algorithm>
#include <cmath>

namespace motiondb::core {

StoredFloor::StoredFloor(const Model& model, double leg_length_m)
    : model_(model),
      leg_length_m_(leg_length_m),
      axes_(static_cast<std::size_t>(model.frame_count())),
      lengths_(axes_.size()) {
  const double rate = model.settings().frame_rate_hz;
  const int span = std::max(1, static_cast<int>(std::lround(rate / 4)));
  double length = 0;
  for (const ModelClip& clip : model.clips()) {
    const double scale = leg_length_m / clip.leg_length_m;
    for (int f = clip.first_frame; f < clip.first_frame + clip.frame_count; ++f) {
      const double heading = model.root_path()(f, 2);
      axes_[f] = {scale * std::cos(heading), scale * std::sin(heading)};
      if (f > clip.first_frame) {
        const FloorPose step = Between(f - 1, f);
        length += std::hypot(step.x, step.y);
      }
      lengths_[f] = length;
      if (f >= clip.first_frame + span) {
        const FloorPose way = Between(f - span, f);
        top_speed_m_s_ = std::max(top_speed_m_s_, std::hypot(way.x, way.y) * rate / span);
        top_turn_rad_s_ = std::max(top_turn_rad_s_, std::abs(way.heading) * rate / span);
      }
    }
  }
}

}  // namespace motiondb::core
