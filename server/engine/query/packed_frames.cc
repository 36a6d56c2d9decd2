#include "server/engine/query/packed_frames.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <set>

#include "core/motion/error.h"

namespace motiondb::server {

using core::FieldViolation;

static_assert(std::endian::native == std::endian::little,
              "packed floats are copied without conversion");

absl::StatusOr<core::FrameMatrix> Unpack(std::string_view field, std::string_view name,
                                         const PackedFrames& packed, int columns) {
  if (packed.frame_count < 1) {
    return FieldViolation(fmt::format("{}.frame_count", field), "expected at least 1, got {}",
                          packed.frame_count);
  }
  const std::int64_t expected = std::int64_t{4} * packed.frame_count * columns;
  if (std::ssize(packed.values) != expected) {
    return FieldViolation(fmt::format("{}.{}", field, name),
                          "expected {} bytes, {} frames of {} float32, got {}", expected,
                          packed.frame_count, columns, packed.values.size());
  }
  core::FrameMatrix matrix(packed.frame_count, columns);
  std::memcpy(matrix.data(), packed.values.data(), packed.values.size());
  return matrix;
}

absl::Status CheckFinite(std::string_view field, const core::FrameMatrix& frames) {
  for (Eigen::Index frame = 0; frame < frames.rows(); ++frame) {
    if (!frames.row(frame).allFinite()) {
      return FieldViolation(field, "frame {} has a value that is not finite", frame);
    }
  }
  return absl::OkStatus();
}

absl::Status CheckMarkers(std::string_view field, const std::vector<std::string>& names,
                          const core::FrameMatrix& positions) {
  for (Eigen::Index frame = 0; frame < positions.rows(); ++frame) {
    for (std::size_t marker = 0; marker < names.size(); ++marker) {
      const auto position = positions.row(frame).segment<3>(static_cast<Eigen::Index>(3 * marker));
      if (position.allFinite() || position.array().isNaN().all()) continue;
      return FieldViolation(field,
                            "frame {}, marker '{}': expected three finite numbers, or three NaN "
                            "for a missing marker",
                            frame, names[marker]);
    }
  }
  return absl::OkStatus();
}

absl::Status CheckUnique(std::string_view field, const std::vector<std::string>& names) {
  std::set<std::string_view> seen;
  for (const std::string& name : names) {
    if (name.empty()) return FieldViolation(field, "a marker name is empty");
    if (!seen.insert(name).second) return FieldViolation(field, "duplicate marker name '{}'", name);
  }
  return absl::OkStatus();
}

}  // namespace motiondb::server
