#include "core/planning/synthesis.h"

#include <algorithm>
#include <cmath>

#include "core/model/model.h"
#include "core/planning/ease.h"
#include "core/planning/foot_lock.h"

namespace motiondb::core {
namespace {

constexpr double kFadeInSeconds = 0.4;    // from the state that the plan begins in
constexpr double kContactContext = 0.75;  // seconds around the frames played that contacts look at

Eigen::RowVectorXf StoredPositions(const Model& model, int frame) {
  return PositionsOf(model.states().row(frame).cwiseProduct(model.scale().divisor));
}

// Contacts of the frames first ... last of one clip, looked at with some of the clip around them.
ContactMatrix StoredContacts(const Model& model, const Feet& feet, int first, int last) {
  const ModelClip& clip = model.clips()[model.clip_of_frame(first)];
  const double rate = model.settings().frame_rate_hz;
  const int context = static_cast<int>(kContactContext * rate);
  const int begin = std::max(clip.first_frame, first - context);
  const int end = std::min(clip.first_frame + clip.frame_count, last + 1 + context);
  FrameMatrix positions(end - begin, model.states().cols() / 2);
  for (int f = begin; f < end; ++f) {
    const auto root = model.root_path().row(f);
    positions.row(f - begin) =
        OnFloor(StoredPositions(model, f), clip.leg_length_m, {root[0], root[1], root[2]});
  }
  return DetectContacts(feet, positions, rate, clip.leg_length_m)
      .middleRows(first - begin, last - first + 1);
}

// Contacts of each frame's main stored frame.
ContactMatrix PlayedContacts(const Model& model, const Feet& feet,
                             const std::vector<PlayedFrame>& played) {
  ContactMatrix contacts;
  for (std::size_t begin = 0; begin < played.size();) {
    std::size_t end = begin + 1;
    while (end < played.size() && played[end].main == played[end - 1].main + 1) ++end;
    const ContactMatrix run = StoredContacts(model, feet, played[begin].main, played[end - 1].main);
    if (begin == 0) contacts.resize(static_cast<Eigen::Index>(played.size()), run.cols());
    contacts.middleRows(static_cast<Eigen::Index>(begin), run.rows()) = run;
    begin = end;
  }
  return contacts;
}

}  // namespace

Eigen::RowVectorXf PositionsOf(const Eigen::Ref<const Eigen::RowVectorXf>& state) {
  Eigen::RowVectorXf positions(state.size() / 2);
  for (Eigen::Index m = 0; m < state.size() / 6; ++m) {
    positions.segment<3>(3 * m) = state.segment<3>(6 * m);
  }
  return positions;
}

Eigen::RowVectorXf OnFloor(const Eigen::Ref<const Eigen::RowVectorXf>& positions,
                           double leg_length_m, const FloorPose& root) {
  const double c = std::cos(root.heading);
  const double s = std::sin(root.heading);
  Eigen::RowVectorXf world(positions.size());
  for (Eigen::Index m = 0; m < positions.size() / 3; ++m) {
    const Eigen::Vector3d p = leg_length_m * positions.segment<3>(3 * m).cast<double>().transpose();
    world[3 * m] = static_cast<float>(root.x + c * p.x() - s * p.y());
    world[3 * m + 1] = static_cast<float>(root.y + s * p.x() + c * p.y());
    world[3 * m + 2] = static_cast<float>(p.z());
  }
  return world;
}

SynthesisedMotion Synthesise(const Model& model, const Body& body, const PlanOrigin& origin,
                             const SplicedPath& path, const std::vector<FloorPose>& root) {
  const double rate = model.settings().frame_rate_hz;
  const std::vector<PlayedFrame> played = PlayedFrames(path);
  // What the body is off the stored frame when it begins; nothing where a marker was missing.
  Eigen::RowVectorXf off = PositionsOf(origin.state) - StoredPositions(model, origin.frame);
  off = off.array().isFinite().select(off, 0.0F);

  SynthesisedMotion motion;
  motion.markers.names = model.marker_set().markers;
  motion.markers.frame_rate_hz = rate;
  motion.markers.positions_m.resize(static_cast<Eigen::Index>(played.size()), off.size());
  for (std::size_t t = 0; t < played.size(); ++t) {
    const PlayedFrame& frame = played[t];
    Eigen::RowVectorXf positions = StoredPositions(model, frame.main);
    if (frame.fading >= 0) {
      positions +=
          static_cast<float>(frame.share) * (StoredPositions(model, frame.fading) - positions);
    }
    const double faded_in = Ease(static_cast<double>(t) / (kFadeInSeconds * rate));
    positions += static_cast<float>(1 - faded_in) * off;
    motion.markers.positions_m.row(static_cast<Eigen::Index>(t)) =
        OnFloor(positions, body.leg_length_m(), root[t]);
  }
  motion.contacts = PlayedContacts(model, body.stored_feet(), played);
  body.Fit(motion.markers.positions_m);
  LockFeet(body.feet(), motion.contacts, rate, body.leg_length_m(), motion.markers.positions_m);
  return motion;
}

}  // namespace motiondb::core
