#include "core/planning/start.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/inference/observation.h"
#include "core/model/model.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

// A plan needs somewhere to go on to: the last half second of a clip leads nowhere.
constexpr double kRunwaySeconds = 0.5;
constexpr int kMostOrigins = 5;

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

// The frame with the smallest `cost` of each clip that may be played; of them the best few.
template <typename Cost>
absl::StatusOr<std::vector<int>> CheapestFrames(const Model& model,
                                                const std::vector<std::string>& labels, Cost cost) {
  std::vector<std::pair<double, int>> best;
  for (const ModelClip& clip : model.clips()) {
    if (!MayPlay(clip, labels)) continue;
    const int frames = std::max(1, clip.frame_count - Runway(model));
    std::pair<double, int> of_clip{cost(clip.first_frame), clip.first_frame};
    for (int f = clip.first_frame + 1; f < clip.first_frame + frames; ++f) {
      if (const double c = cost(f); c < of_clip.first) of_clip = {c, f};
    }
    best.push_back(of_clip);
  }
  if (best.empty()) return InvalidArgument("labels: no clip has one of them");
  std::sort(best.begin(), best.end());
  std::vector<int> frames;
  for (const auto& [unused, frame] : best) {
    if (static_cast<int>(frames.size()) < kMostOrigins) frames.push_back(frame);
  }
  return frames;
}

// By squared distance of scaled states; what is missing (NaN) counts for nothing.
absl::StatusOr<std::vector<int>> FramesMostLike(const Model& model,
                                                const std::vector<std::string>& labels,
                                                const Eigen::RowVectorXf& scaled) {
  const Eigen::RowVectorXf known =
      scaled.array().isFinite().select(Eigen::RowVectorXf::Ones(scaled.size()), 0.0F);
  const Eigen::RowVectorXf target = scaled.array().isFinite().select(scaled, 0.0F);
  return CheapestFrames(model, labels, [&](int f) {
    return ((model.states().row(f) - target).array() * known.array()).matrix().squaredNorm();
  });
}

// Of the stored frame itself.
PlanOrigin AtFrame(const Model& model, int frame) {
  return {.frame = frame,
          .state = model.states().row(frame).cwiseProduct(model.scale().divisor),
          .leg_length_m = model.clips()[model.clip_of_frame(frame)].leg_length_m};
}

// One origin for each frame, all beginning in the same state.
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
                                                        const std::vector<std::string>& labels) {
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, observation));
  const Eigen::Index last = scaled.rows() - 1;
  if (!scaled.row(last).array().isFinite().any()) {
    return InvalidArgument("observation: its last frame has no marker");
  }
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<int> frames,
                            FramesMostLike(model, labels, scaled.row(last)));
  return Origins({.state = observation.states.row(last), .leg_length_m = observation.leg_length_m},
                 frames);
}

absl::StatusOr<std::vector<PlanOrigin>> FromClip(const Model& model, const ClipMoment& moment,
                                                 const std::vector<std::string>& labels) {
  MOTIONDB_ASSIGN_OR_RETURN(const int frame, FrameOfClip(model, moment));
  const PlanOrigin origin = AtFrame(model, frame);
  const ModelClip& clip = model.clips()[model.clip_of_frame(frame)];
  const int left = clip.first_frame + clip.frame_count - 1 - frame;
  if (MayPlay(clip, labels) && left >= Runway(model)) return std::vector<PlanOrigin>{origin};
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<int> frames,
                            FramesMostLike(model, labels, model.states().row(frame)));
  return Origins(origin, frames);
}

absl::StatusOr<std::vector<PlanOrigin>> Standing(const Model& model,
                                                 const std::vector<std::string>& labels) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<int> frames,
                            CheapestFrames(model, labels, [&](int f) {
                              double speed = 0;
                              for (Eigen::Index m = 0; m < model.states().cols() / 6; ++m) {
                                speed += model.states().row(f).segment<3>(6 * m + 3).squaredNorm();
                              }
                              return speed;
                            }));
  std::vector<PlanOrigin> origins;
  for (const int frame : frames) origins.push_back(AtFrame(model, frame));
  return origins;
}

}  // namespace

absl::StatusOr<std::vector<PlanOrigin>> FindOrigins(const Model& model, const PlanStart& start,
                                                    const std::vector<std::string>& labels) {
  if (start.observation) return FromObservation(model, *start.observation, labels);
  if (start.clip) return FromClip(model, *start.clip, labels);
  return Standing(model, labels);
}

}  // namespace motiondb::core
