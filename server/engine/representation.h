// Brings motion to a database's markers and frame rate, with a limit on what comes of it. Safe to
// call from any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/motion/states.h"

namespace motiondb::server {

// What may be done at once, beside other calls: what is over within moments, or all that the limits
// allow.
enum class Allowed { kLightWork, kAllWork };

// How much may be done, and until when.
struct WorkTerms {
  Allowed allowed = Allowed::kAllWork;
  core::Cancelled cancelled;
};

struct RepresentationLimits {
  double frame_rate_hz = 0;  // of the database
  // At that rate, and of the motion at its own; of 34 markers, of more markers as many fewer.
  int max_frames = 0;
  WorkTerms terms;
};

// Whether a motion was not represented because that is heavy work, which was not allowed.
bool IsHeavyWork(const absl::Status& status);

// As core::Represent. RESOURCE_EXHAUSTED for a motion that lasts too long: a file of a few bytes
// can claim to last a century. CANCELLED.
absl::StatusOr<core::StateSequence> RepresentWithin(const RepresentationLimits& limits,
                                                    const core::MarkerScheme& scheme,
                                                    const core::Motion& motion, core::Gaps gaps,
                                                    std::optional<double> leg_length_m,
                                                    std::vector<std::string>* notes = nullptr);

// Before a motion becomes the markers of a set, at the limits' frame rate. RESOURCE_EXHAUSTED for
// one that lasts too long, INVALID_ARGUMENT for one that has more joints in its frames than can be
// placed; IsHeavyWork.
absl::Status CheckSize(const RepresentationLimits& limits, int marker_count,
                       const core::Motion& motion);

// Frame rate of the motion's own frames.
double FrameRate(const core::Motion& motion);

}  // namespace motiondb::server
