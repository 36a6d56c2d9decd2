// Finds the stored parts that are most similar to a motion.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/motion/states.h"

namespace motiondb::core {

class ClipMask;
class Model;

inline constexpr int kMaxMatches = 1000;

struct FindOptions {
  int top_count = 10;  // maximum number of matches, 1 to kMaxMatches
  // Compares all clips instead of those that are probably similar.
  bool exhaustive = false;
  // Clips to search (core/model/clip_mask.h), made for the model; null: all.
  std::shared_ptr<const ClipMask> mask = nullptr;
};

// INVALID_ARGUMENT naming the field if an option is out of range.
absl::Status CheckOptions(const FindOptions& options);

// A part of a motion, from its start; absent: from the start, to the end.
struct TimeRange {
  std::optional<double> start_seconds;
  std::optional<double> end_seconds;
};

// The motion to find.
struct MotionPart {
  FrameMatrix states;  // frames x D, scaled; NaN: missing
  int clip = -1;       // index into Model::clips() of the clip that has it; -1: an observation
};

// Return a part of an observation (not scaled; the model's markers and frame rate) or of a stored
// clip: the frames from round(start * rate) to round(end * rate) - 1, at least one.
// INVALID_ARGUMENT naming start_seconds, end_seconds or clip (with reason CLIP_NOT_FOUND), or as
// ScaledObservation.
absl::StatusOr<MotionPart> PartOfObservation(const Model& model, const StateSequence& observation,
                                             const TimeRange& part);
absl::StatusOr<MotionPart> PartOfClip(const Model& model, const std::string& clip,
                                      const TimeRange& part);

struct MotionMatch {
  int clip = 0;         // index into Model::clips()
  int first_frame = 0;  // of the clip
  int frame_count = 0;
  // 1 / (1 + cost / 2 K): 1 for the same motion, and 0.5 for a difference as large as the mean
  // difference between aligned motions of one label. `cost`: of the path (cheapest_path.h) at the
  // database's frame rate, per observed frame; K: number of dimensions of the metric. So
  // scores of different observations can be compared.
  double score = 0;
};

// Finds the parts of stored clips that are most similar to `motion`, best first; of equal ones, in
// order of clip id and time. Parts of one clip are disjoint (CheapestPaths::Disjoint). Missing
// markers are filled in; markers never seen are excluded.
//
// Within a compared clip the result is exact. All clips are compared if `exhaustive`, or if there
// are at most 32 or 2 * top_count. Otherwise these are compared: the clip of `motion`, and of the
// max(256, 4 * top_count) clips with nodes nearest to the motion (shortlist.h) the max(32, 2 *
// top_count) with the cheapest paths at about 30 frames a second. So a similar part may be missed
// in a clip that is less similar than all of these, by nodes or at that rate.
//
// INVALID_ARGUMENT if an option is out of range; FAILED_PRECONDITION if the model has no metric;
// CANCELLED.
absl::StatusOr<std::vector<MotionMatch>> FindMotion(const Model& model, MotionPart motion,
                                                    const FindOptions& options,
                                                    const Cancelled& cancelled = {});

}  // namespace motiondb::core
