#include "core/planning/start.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/inference/observation.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

// A plan needs somewhere to go on to: the last half second of a clip leads nowhere.
constexpr double kRunwaySeconds = 0.5;

absl::StatusOr<int> FrameOfClip(const Model& model, const ClipMoment& moment) {
  const auto clip = std::find_if(model.clips().begin(), model.clips().end(),
                                 [&](const ModelClip& c) { return c.id == moment.clip; });
  if (clip == model.clips().end()) {
    return NotFound("clip '{}' is not in the model", moment.clip);
  }
  const double frame = std::round(moment.seconds * model.settings().frame_rate_hz);
  if (!(frame >= 0 && frame < clip->frame_count)) {
    return absl::OutOfRangeError(
        fmt::format("clip '{}' lasts {:.3f} s: expected a moment in it, got {} s", clip->id,
                    (clip->frame_count - 1) / model.settings().frame_rate_hz, moment.seconds));
  }
  return clip->first_frame + static_cast<int>(frame);
}

bool MayPlay(const ModelClip& clip, const std::vector<std::string>& labels) {
  return labels.empty() || std::find(labels.begin(), labels.end(), clip.label) != labels.end();
}

int Runway(const Model& model) {
  return static_cast<int>(kRunwaySeconds * model.settings().frame_rate_hz);
}

// The frame with the smallest `cost` among the clips that may be played.
template <typename Cost>
absl::StatusOr<int> CheapestFrame(const Model& model, const std::vector<std::string>& labels,
                                  Cost cost) {
  const int runway = Runway(model);
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const ModelClip& clip : model.clips()) {
    if (!MayPlay(clip, labels)) continue;
    const int frames = std::max(1, clip.frame_count - runway);
    for (int f = clip.first_frame; f < clip.first_frame + frames; ++f) {
      if (const double c = cost(f); c < least) {
        least = c;
        best = f;
      }
    }
  }
  if (best < 0) return InvalidArgument("labels: no clip has one of them");
  return best;
}

// By squared distance of scaled states; what is missing (NaN) counts for nothing.
absl::StatusOr<int> FrameMostLike(const Model& model, const std::vector<std::string>& labels,
                                  const Eigen::RowVectorXf& scaled) {
  const Eigen::RowVectorXf known =
      scaled.array().isFinite().select(Eigen::RowVectorXf::Ones(scaled.size()), 0.0F);
  const Eigen::RowVectorXf target = scaled.array().isFinite().select(scaled, 0.0F);
  return CheapestFrame(model, labels, [&](int f) {
    return ((model.states().row(f) - target).array() * known.array()).matrix().squaredNorm();
  });
}

// Of the stored frame itself.
PlanOrigin AtFrame(const Model& model, int frame) {
  return {.frame = frame,
          .state = model.states().row(frame).cwiseProduct(model.scale().divisor),
          .leg_length_m = model.clips()[model.clip_of_frame(frame)].leg_length_m};
}

absl::StatusOr<PlanOrigin> FromObservation(const Model& model, const StateSequence& observation,
                                           const std::vector<std::string>& labels) {
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, observation));
  const Eigen::Index last = scaled.rows() - 1;
  if (!scaled.row(last).array().isFinite().any()) {
    return InvalidArgument("observation: its last frame has no marker");
  }
  PlanOrigin origin{.state = observation.states.row(last),
                    .leg_length_m = observation.leg_length_m};
  MOTIONDB_ASSIGN_OR_RETURN(origin.frame, FrameMostLike(model, labels, scaled.row(last)));
  return origin;
}

}  // namespace

absl::StatusOr<PlanOrigin> FindOrigin(const Model& model, const PlanStart& start,
                                      const std::vector<std::string>& labels) {
  if (start.observation) return FromObservation(model, *start.observation, labels);
  if (start.clip) {
    MOTIONDB_ASSIGN_OR_RETURN(const int frame, FrameOfClip(model, *start.clip));
    PlanOrigin origin = AtFrame(model, frame);
    const ModelClip& clip = model.clips()[model.clip_of_frame(frame)];
    const int left = clip.first_frame + clip.frame_count - 1 - frame;
    if (!MayPlay(clip, labels) || left < Runway(model)) {
      MOTIONDB_ASSIGN_OR_RETURN(origin.frame,
                                FrameMostLike(model, labels, model.states().row(frame)));
    }
    return origin;
  }
  MOTIONDB_ASSIGN_OR_RETURN(const int frame, CheapestFrame(model, labels, [&](int f) {
                              double speed = 0;
                              for (Eigen::Index m = 0; m < model.states().cols() / 6; ++m) {
                                speed += model.states().row(f).segment<3>(6 * m + 3).squaredNorm();
                              }
                              return speed;
                            }));
  return AtFrame(model, frame);
}

}  // namespace motiondb::core
