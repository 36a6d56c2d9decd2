// StateSequence <-> bytes; docs/storage_format.md gives the layout. Encoding what was decoded gives
// the same bytes. Decoding gives DATA_LOSS for any other bytes, and takes no memory that they do
// not account for. Safe to call from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/skeleton.h"
#include "core/motion/states.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

// INVALID_ARGUMENT unless there is a root pose for each frame.
absl::Status EncodeStates(const core::StateSequence& sequence, ByteSink& sink);
absl::StatusOr<core::StateSequence> DecodeStates(ByteSource& source);

// The same in two steps, for a reader who has a place for the frames.
struct StatesHeader {
  double frame_rate_hz = 0;
  double leg_length_m = 0;
  std::int32_t frame_count = 0;
  std::int32_t dimension_count = 0;
  std::vector<core::FrameSpan> glitches = {};
};
// What follows it in the source is exactly the frames that it tells of.
absl::StatusOr<StatesHeader> DecodeStatesHeader(ByteSource& source);
// `states` has frame_count * dimension_count numbers, row-major, `root_path` 3 * frame_count.
absl::Status DecodeStatesFrames(ByteSource& source, std::span<float> states,
                                std::span<double> root_path);

// Skeleton <-> bytes; docs/storage_format.md gives the layout. Encoding what was decoded gives the
// same bytes, and alike skeletons give the same bytes. Decoding gives DATA_LOSS for any bytes that
// are not a skeleton's, and takes no memory that they do not account for. Safe to call from any
// thread.

absl::Status EncodeSkeleton(const core::Skeleton& skeleton, ByteSink& sink);
absl::StatusOr<core::Skeleton> DecodeSkeleton(ByteSource& source);

}  // namespace motiondb::storage
