// Binary formats of state sequences and skeletons; docs/storage_format.md describes the layout.
// Encoding a decoded value returns the same bytes. Decoding returns DATA_LOSS for invalid bytes and
// never allocates more memory than their size justifies.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/motion.h"
#include "core/motion/states.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

// INVALID_ARGUMENT if the number of root poses differs from the number of frames.
absl::Status EncodeStates(const core::StateSequence& sequence, ByteSink& sink);
absl::StatusOr<core::StateSequence> DecodeStates(ByteSource& source);

// Decoding in two steps, into memory of the caller.
struct StatesHeader {
  double frame_rate_hz = 0;
  double leg_length_m = 0;
  std::int32_t frame_count = 0;
  std::int32_t dimension_count = 0;
  std::vector<core::FrameSpan> glitches = {};
};
// Checks that exactly the bytes of frame_count frames follow.
absl::StatusOr<StatesHeader> DecodeStatesHeader(ByteSource& source);
// `states` has frame_count * dimension_count numbers, row-major, `root_path` 3 * frame_count.
absl::Status DecodeStatesFrames(ByteSource& source, std::span<float> states,
                                std::span<double> root_path);

// Equal skeletons have equal encodings.
absl::Status EncodeSkeleton(const core::Skeleton& skeleton, ByteSink& sink);
absl::StatusOr<core::Skeleton> DecodeSkeleton(ByteSource& source);

}  // namespace motiondb::storage
