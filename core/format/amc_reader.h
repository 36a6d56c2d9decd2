// Reads AMC (Acclaim motion) files with the ASF of their skeleton. Keeps no state; safe to call
// from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::core {

// The ASF states the unit (1/length inches) and, by its format, y up. The frame rate is that of
// `options`, or of ":SAMPLES-PER-SECOND" if the AMC has it, or 120 Hz, which is reported. Joints
// are laid out as BuildAsfSkeleton says. Errors: see ReadMotionFile.
absl::StatusOr<MotionFile> ReadAmc(SourceFile file, SourceFile skeleton,
                                   const ReadOptions& options);

}  // namespace motiondb::core
