// Reads TRC (track row column) files of marker positions. Keeps no state; safe to call from any
// thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::core {

// TRC states unit and frame rate. The up axis is deduced from markers whose names tell head and
// feet, or else y is assumed, as OpenSim has it. An empty cell or NaN is a missing marker. Errors:
// see ReadMotionFile.
absl::StatusOr<MotionFile> ReadTrc(SourceFile file, const ReadOptions& options);

}  // namespace motiondb::core
