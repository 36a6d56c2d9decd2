// Skeleton <-> bytes; storage/README.md gives the layout. Encoding what was decoded gives the same
// bytes, and alike skeletons give the same bytes. Decoding gives DATA_LOSS for any bytes that are
// not a skeleton's, and takes no memory that they do not account for. Safe to call from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/motion/skeleton.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

absl::Status EncodeSkeleton(const core::Skeleton& skeleton, ByteSink& sink);
absl::StatusOr<core::Skeleton> DecodeSkeleton(ByteSource& source);

}  // namespace motiondb::storage
