// Binary format of a motion between motiondb-import and its caller. It is never stored: both are
// programs of one installation.
#pragma once

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

// INVALID_ARGUMENT if a size exceeds 32 bits.
absl::Status EncodeMotion(const core::MotionFile& file, ByteSink& sink);

// DATA_LOSS for invalid bytes, which a corrupt motiondb-import could send: an invalid skeleton, a
// frame rate out of range, joint angles that are not finite, a marker with some coordinates
// missing, no frame, or names that repeat. Never allocates more memory than their size justifies.
absl::StatusOr<core::MotionFile> DecodeMotion(ByteSource& source);

}  // namespace motiondb::storage
