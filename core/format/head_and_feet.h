// Heads and feet, known by the names of joints or markers, tell a file's up axis and unit where the
// file does not. The functions keep no state and are safe to call from any thread.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/format/motion_file.h"
#include "core/motion/matrix.h"
#include "core/motion/skeleton.h"

namespace motiondb::core {

// The axis along which heads are above feet, over frames spread across the clip. Points are known
// by their names ("Head", "LFHD", "LeftToeBase", "RANK"). Nothing if names do not tell heads and
// feet, or if no axis stands out. positions: frames x 3 * names.size(), in the file's axes and any
// unit.
std::optional<UpAxis> DeduceUpAxis(std::span<const std::string> names,
                                   const FrameMatrix& positions);

// Stature in the file's unit: the way along the bones from a foot up to the head, which does not
// depend on the pose. positions: frames x 3 * joints. Nothing if names do not tell head and feet.
std::optional<double> StatureAlongBones(const Skeleton& skeleton, const FrameMatrix& positions);

// Stature in the file's unit from bare points: the distance between head and feet.
std::optional<double> StatureOfPoints(std::span<const std::string> names,
                                      const FrameMatrix& positions);

// Of m, cm, mm, inch and CMU's 1/0.45 inch, the unit that makes the stature closest to a person's.
// Nothing if none makes it plausible.
std::optional<double> DeduceMetresPerUnit(double stature);

}  // namespace motiondb::core
