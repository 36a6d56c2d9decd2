// Bytes of a motion file -> motion in metres, radians and a z-up world. The door to every reader.
// Functions here keep no state and are safe to call from any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/file_format.h"
#include "core/motion/motion.h"

namespace motiondb::core {

enum class UpAxis { kX, kY, kZ, kMinusX, kMinusY, kMinusZ };

// How a reader came to know a unit or an axis.
enum class Provenance {
  kGiven,    // the caller said so
  kStated,   // the file or its format says so
  kDeduced,  // worked out from the motion itself
  kAssumed,  // nothing to go by: the format's custom
};

// What the reader found out about the file's conventions. Shown to the user on ingest.
struct SourceReport {
  double metres_per_unit = 1;
  Provenance unit_provenance = Provenance::kAssumed;
  UpAxis up_axis = UpAxis::kY;
  Provenance up_provenance = Provenance::kAssumed;
  std::vector<std::string> notes;  // e.g. "frames start at 27", one sentence each
};

// One line for a person: "unit 0.01 m (deduced), y up (stated); <notes>".
std::string Describe(const SourceReport& report);

// Overrides for files whose conventions the caller knows. Must be finite and positive.
struct ReadOptions {
  std::optional<double> metres_per_unit;
  std::optional<UpAxis> up_axis;
  std::optional<double> frame_rate_hz;  // AMC states none: default 120, reported as assumed
};

struct MotionFile {
  Motion motion;
  SourceReport report;
};

// A file in memory: `name` appears in error messages ("walk.bvh:12: expected ...").
struct SourceFile {
  std::string_view name;
  std::string_view bytes;
};

// Reads one motion file. `skeleton` is the ASF of an AMC and is required for that format alone.
//
// Every error is INVALID_ARGUMENT and names file, line (byte offset for C3D) and what was expected.
// A file cut short at any byte is an error unless what is left is itself a complete file. Sizes
// that a file claims are checked against its length before memory is taken for them.
absl::StatusOr<MotionFile> ReadMotionFile(FileFormat format, SourceFile file,
                                          std::optional<SourceFile> skeleton = std::nullopt,
                                          const ReadOptions& options = {});

// Memory (bytes) that ReadMotionFile takes at most, its result included. O(bytes of the file).
std::int64_t MostBytesToRead(FileFormat format, SourceFile file,
                             std::optional<SourceFile> skeleton = std::nullopt);

inline constexpr int kMostJoints = 2000;  // end sites and the tips of bones among them

}  // namespace motiondb::core
