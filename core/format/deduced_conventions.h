// Estimates of a file's unit and up axis from the figure of the person in it.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/format/motion_file.h"
#include "core/motion/matrix.h"
#include "core/motion/skeleton.h"

namespace motiondb::core {

struct DeducedConventions {
  // In the file's unit: along the bones from a foot to the head, so independent of the pose, or for
  // markers the distance of head and feet. Nothing if there is no figure of a person.
  std::optional<double> stature;
  // m, cm, mm, inch or CMU's 1/0.45 inch, in metres: the one for which the stature is closest to a
  // person's. Nothing if none is plausible.
  std::optional<double> metres_per_unit;
  // The axis along which head or shoulders are above the feet in most frames. Nothing if no axis
  // dominates.
  std::optional<UpAxis> up_axis;
};

// Heads and feet are recognised by their names ("Head", "LFHD", "LeftToeBase", "RANK"), otherwise
// by the figure (core/mapping/figure.h). positions: frames x 3 * names.size(), in the file's axes,
// any unit. `skeleton`: of the names, null for markers. O(frames + points) and the search for the
// figure.
DeducedConventions DeduceConventions(std::span<const std::string> names,
                                     const FrameMatrix& positions,
                                     const Skeleton* skeleton = nullptr);

// Decides the unit of a file (core/format/conventions.h). A file without a known unit gets the unit
// that gives its figure the stature of a person, or without a figure the `usual` one of its format;
// a note says so.
void DecideUnit(std::optional<double> given, std::optional<double> stated,
                const DeducedConventions& deduced, double usual, SourceReport& report);

}  // namespace motiondb::core
