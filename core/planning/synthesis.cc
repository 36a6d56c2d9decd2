#include "core/planning/synthesis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/inference/observation.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/planning/foot_lock.h"
#include "core/planning/splice.h"

namespace motiondb::core {

namespace {

// A plan must be able to continue: the last half second of a clip leads nowhere.
constexpr double kRunwaySeconds = 0.5;
constexpr int kMaxOrigins = 5;

absl::StatusOr<int> FrameOfClip(const Model& model, const ClipMoment& moment) {
  const auto clip = std::find_if(model.clips().begin(), model.clips().end(),
                                 [&](const ModelClip& c) { return c.id == moment.clip; });
  if (clip == model.clips().end()) {
    return NotFound("clip '{}' is not in the model", moment.clip);
  }
  const double frame = std::round(moment.seconds * model.settings().frame_rate_hz);
  if (!(frame >= 0 && frame < clip->frame_count)) {
    return absl::OutOfRangeError(
        fmt::format("clip '{}' lasts {:.3f} s: expected a time within it, got {} s", clip->id,
                    (clip->frame_count - 1) / model.settings().frame_rate_hz, moment.seconds));
  }
  return clip->first_frame + static_cast<int>(frame);
}

int Runway(const Model& model) {
  return static_cast<int>(kRunwaySeconds * model.settings().frame_rate_hz);
}

// Returns the frame with the smallest `cost` of each playable range; of these, the best few.
template <typename Cost>
absl::StatusOr<std::vector<int>> CheapestFrames(const Model& model, const Playable& playable,
                                                Cost cost) {
  std::vector<std::pair<double, int>> best;
  for (const auto& [clip, first, end] : PlayableRanges(model, playable)) {
    const int last = std::max(first, end - Runway(model) - 1);
    constexpr double kNone = std::numeric_limits<double>::infinity();
    std::pair<double, int> of_range{kNone, first};
    for (int f = first; f <= last; ++f) {
      if (model.HasGlitch(f, f)) continue;
      if (const double c = cost(f); c < of_range.first) of_range = {c, f};
    }
    best.push_back(of_range);
  }
  if (best.empty()) return FieldViolation("labels", "expected a label of a stored clip");
  std::sort(best.begin(), best.end());
  std::vector<int> frames;
  for (const auto& [unused, frame] : best) {
    if (static_cast<int>(frames.size()) < kMaxOrigins) frames.push_back(frame);
  }
  return frames;
}

// By squared distance of scaled states; missing values (NaN) are ignored.
absl::StatusOr<std::vector<int>> FramesMostLike(const Model& model, const Playable& playable,
                                                const Eigen::RowVectorXf& scaled) {
  const Eigen::RowVectorXf known =
      scaled.array().isFinite().select(Eigen::RowVectorXf::Ones(scaled.size()), 0.0F);
  const Eigen::RowVectorXf target = scaled.array().isFinite().select(scaled, 0.0F);
  return CheapestFrames(model, playable, [&](int f) {
    return ((model.states().row(f) - target).array() * known.array()).matrix().squaredNorm();
  });
}

// Returns the origin for the stored frame itself.
PlanOrigin AtFrame(const Model& model, int frame) {
  return {.frame = frame,
          .state = model.states().row(frame).cwiseProduct(model.scale().divisor),
          .leg_length_m = model.clips()[model.clip_of_frame(frame)].leg_length_m};
}

// Returns one origin for each frame, all with the same start state.
std::vector<PlanOrigin> Origins(const PlanOrigin& begin, const std::vector<int>& frames) {
  std::vector<PlanOrigin> origins;
  for (const int frame : frames) {
    origins.push_back(begin);
    origins.back().frame = frame;
  }
  return origins;
}

absl::StatusOr<std::vector<PlanOrigin>> FromObservation(const Model& model,
                                                        const StateSequence& observation,
                                                        const Playable& playable) {
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, observation));
  const Eigen::Index last = scaled.rows() - 1;
  if (!scaled.row(last).array().isFinite().any()) {
    return InvalidArgument("observation: expected a marker in the last frame");
  }
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<int> frames,
                            FramesMostLike(model, playable, scaled.row(last)));
  return Origins({.state = observation.states.row(last), .leg_length_m = observation.leg_length_m},
                 frames);
}

absl::StatusOr<std::vector<PlanOrigin>> FromClip(const Model& model, const ClipMoment& moment,
                                                 const Playable& playable) {
  MOTIONDB_ASSIGN_OR_RETURN(const int frame, FrameOfClip(model, moment));
  const PlanOrigin origin = AtFrame(model, frame);
  for (const PlayableRange& range : PlayableRanges(model, playable)) {
    if (frame >= range.first && frame + Runway(model) < range.end) {
      return std::vector<PlanOrigin>{origin};
    }
  }
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<int> frames,
                            FramesMostLike(model, playable, model.states().row(frame)));
  return Origins(origin, frames);
}

absl::StatusOr<std::vector<PlanOrigin>> Standing(const Model& model, const Playable& playable) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<int> frames,
                            CheapestFrames(model, playable, [&](int f) {
                              double speed = 0;
                              for (Eigen::Index m = 0; m < model.states().cols() / 6; ++m) {
                                speed += model.states().row(f).segment<3>(6 * m + 3).squaredNorm();
                              }
                              return speed;
                            }));
  std::vector<PlanOrigin> origins;
  origins.reserve(frames.size());
  for (const int frame : frames) origins.push_back(AtFrame(model, frame));
  return origins;
}

}  // namespace

absl::StatusOr<std::vector<PlanOrigin>> FindOrigins(const Model& model, const PlanStart& start,
                                                    const Playable& playable) {
  if (start.observation) return FromObservation(model, *start.observation, playable);
  if (start.clip) return FromClip(model, *start.clip, playable);
  return Standing(model, playable);
}

namespace {

constexpr double kFadeInSeconds = 0.4;    // from the state that the plan begins in
constexpr double kContactContext = 0.75;  // seconds around the played frames for contact detection

Eigen::RowVectorXf StoredPositions(const Model& model, int frame) {
  return PositionsOf(model.states().row(frame).cwiseProduct(model.scale().divisor));
}

// Returns the contacts of the frames first ... last of one clip, detected with some context.
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

// Returns the contacts of each frame's main stored frame.
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
  // Difference of the start state from the stored frame; 0 for missing markers.
  Eigen::RowVectorXf difference = PositionsOf(origin.state) - StoredPositions(model, origin.frame);
  difference = difference.array().isFinite().select(difference, 0.0F);

  SynthesisedMotion motion;
  motion.markers.names = model.marker_set().markers;
  motion.markers.frame_rate_hz = rate;
  motion.markers.positions_m.resize(static_cast<Eigen::Index>(played.size()), difference.size());
  for (std::size_t t = 0; t < played.size(); ++t) {
    const PlayedFrame& frame = played[t];
    Eigen::RowVectorXf positions = StoredPositions(model, frame.main);
    if (frame.fading >= 0) {
      positions +=
          static_cast<float>(frame.share) * (StoredPositions(model, frame.fading) - positions);
    }
    const double faded_in = Ease(static_cast<double>(t) / (kFadeInSeconds * rate));
    positions += static_cast<float>(1 - faded_in) * difference;
    motion.markers.positions_m.row(static_cast<Eigen::Index>(t)) =
        OnFloor(positions, body.leg_length_m(), root[t]);
  }
  motion.contacts = PlayedContacts(model, body.stored_feet(), played);
  body.Fit(motion.markers.positions_m);
  LockFeet(body.feet(), motion.contacts, rate, body.leg_length_m(), motion.markers.positions_m);
  return motion;
}

}  // namespace motiondb::core
