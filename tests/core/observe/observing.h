// Observers that tests feed and ask, each step required to succeed. Functions keep no state.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/observe/observer.h"
#include "tests/core/observe/point_motion.h"

namespace motiondb::tests {

// Of the points' own markers.
std::unique_ptr<core::Observer> Observe(const core::Model& model,
                                        const core::ObserverOptions& options = {},
                                        std::optional<double> leg_length_m = kLegLength_m,
                                        double rate = 60);
void Append(core::Observer& observer, std::int64_t first_frame, const core::FrameMatrix& frames);
core::Observed Answer(core::Observer& observer);

void CheckLabels(const std::vector<core::LabelScore>& a, const std::vector<core::LabelScore>& b);
void CheckSame(const core::Observed& a, const core::Observed& b);

// A stream with markers missing here and there; hips are there.
core::MarkerMotion Stream(int frames);

}  // namespace motiondb::tests
