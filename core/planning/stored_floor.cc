#include "core/planning/stored_floor.h"

#include <algorithm>
#include <cmath>

#include "core/model/model.h"

namespace motiondb::core {

StoredFloor::StoredFloor(const Model& model, double leg_length_m)
    : leg_length_m_(leg_length_m),
      poses_(static_cast<std::size_t>(model.frame_count())),
      facings_(poses_.size()),
      lengths_(static_cast<std::size_t>(model.frame_count())) {
  const double rate = model.settings().frame_rate_hz;
  const int span = std::max(1, static_cast<int>(std::lround(rate / 4)));
  double length = 0;
  for (const ModelClip& clip : model.clips()) {
    const double scale = leg_length_m / clip.leg_length_m;
    for (int f = clip.first_frame; f < clip.first_frame + clip.frame_count; ++f) {
      const auto row = model.root_path().row(f);
      poses_[f] = {scale * row[0], scale * row[1], row[2]};
      facings_[f] = {std::cos(poses_[f].heading), std::sin(poses_[f].heading)};
      if (f > clip.first_frame) {
        const FloorPose step = RelativeTo(poses_[f - 1], poses_[f]);
        length += std::hypot(step.x, step.y);
      }
      lengths_[f] = length;
      if (f >= clip.first_frame + span) {
        const FloorPose way = RelativeTo(poses_[f - span], poses_[f]);
        top_speed_m_s_ = std::max(top_speed_m_s_, std::hypot(way.x, way.y) * rate / span);
        top_turn_rad_s_ = std::max(top_turn_rad_s_, std::abs(way.heading) * rate / span);
      }
    }
  }
}

}  // namespace motiondb::core
