// Creates and feeds observers; each step is required to succeed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/observe/observer.h"
#include "tests/core/observe/point_motion.h"

namespace motiondb::tests {

// Returns an observer on the points' own markers.
std::unique_ptr<core::Observer> Observe(const core::Model& model,
                                        const core::ObserverOptions& options = {},
                                        std::optional<double> leg_length_m = kLegLength_m,
                                        double rate = 60);
void Append(core::Observer& observer, std::int64_t first_frame, const core::FrameMatrix& frames);
core::Observed Answer(core::Observer& observer);

void CheckLabels(const std::vector<core::LabelScore>& a, const std::vector<core::LabelScore>& b);
void CheckSame(const core::Observed& a, const core::Observed& b);

// Returns a motion with some markers missing, but never the hips.
core::MarkerMotion Stream(int frames);

}  // namespace motiondb::tests
