// Which points of a C3D file are markers, and their names.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/format/c3d_parameters.h"

namespace motiondb::core {

struct C3dMarker {
  std::size_t point = 0;  // its place among the points of a frame
  std::string name;       // distinct UTF-8
};

// The markers among the first `points` points, named by POINT:LABELS, LABELS2 and so on. Points
// that POINT:ANGLES, FORCES, MOMENTS, POWERS or SCALARS list are not positions and are left out. A
// "subject:" before all labels is dropped. Adds to `notes` what was changed.
std::vector<C3dMarker> C3dMarkers(const C3dParameters& parameters, int points,
                                  std::vector<std::string>& notes);

}  // namespace motiondb::core
