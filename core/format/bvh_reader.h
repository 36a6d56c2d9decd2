// Reads BVH (Biovision hierarchy) files. Keeps no state; safe to call from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::core {

// BVH states neither unit nor up axis. The unit is deduced from the skeleton's stature, the up axis
// from where heads are above feet in the motion itself (zero poses may lie down), unless `options`
// give them; otherwise cm and y up are assumed. Position channels replace the joint's OFFSET, as
// Blender and MotionBuilder play them. Errors: see ReadMotionFile.
absl::StatusOr<MotionFile> ReadBvh(SourceFile file, const ReadOptions& options);

}  // namespace motiondb::core
