// Checks that the motion in a file can be of a person. If an option of the command line probably
// corrects an error, the error has it as the resource "option" (core/motion/error.h), for example
// "--metres-per-unit 0.01".
#pragma once

#include "absl/status/status.h"
#include "core/format/motion_file.h"
#include "core/motion/states.h"

namespace motiondb::core {

inline constexpr double kMinPersonLeg_m = 0.3;
inline constexpr double kMaxPersonLeg_m = 1.5;

// A motion needs at least one frame for this many frames of the database. At a lower rate there is
// only interpolation, and a few bytes would become hours of motion.
inline constexpr double kMaxFramesPerSourceFrame = 32;

// Returns INVALID_ARGUMENT for a frame rate that is too low for a database.
absl::Status CheckFrameRate(double frame_rate_hz, double database_rate_hz);

// Returns INVALID_ARGUMENT, with the probably intended value, for a given leg length that no person
// has.
absl::Status CheckGivenLegLength(double leg_length_m);

// Returns INVALID_ARGUMENT, with the unit that was probably intended, for legs shorter than
// kMinPersonLeg_m or longer than kMaxPersonLeg_m, as measured. `report`: of the file.
absl::Status CheckMeasuredLeg(double leg_length_m, const SourceReport& report);

// As CheckMeasuredLeg, for legs measured in states or positions: a given leg length does not hide a
// wrong unit. OK if no frame has a whole leg: an estimate from other markers says nothing.
absl::Status CheckBodySize(const MarkerSet& set, const StateSequence& states,
                           const SourceReport& report);
absl::Status CheckBodySize(const MarkerSet& set, const MarkerMotion& motion,
                           const SourceReport& report);

// Returns INVALID_ARGUMENT, with the up axis that was probably intended, if the body lies or is
// upside down in 95 % of the frames. A person can lie throughout a clip, but usually the up axis is
// wrong. OK for a set without legs or without the markers Pelvis and Neck.
absl::Status CheckPosture(const MarkerSet& set, const StateSequence& states,
                          const SourceReport& report);

}  // namespace motiondb::core
