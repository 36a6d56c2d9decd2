// Reads motion files: bytes to motion in metres and radians, z up. Entry point to all readers.
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

// How a reader determined a unit or an axis.
enum class Provenance {
  kGiven,    // by the caller
  kStated,   // by the file or its format
  kDeduced,  // estimated from the motion
  kAssumed,  // default of the format
};

// The file's conventions as the reader determined them. Shown to the user on ingest.
struct SourceReport {
  double metres_per_unit = 1;
  Provenance unit_provenance = Provenance::kAssumed;
  UpAxis up_axis = UpAxis::kY;
  Provenance up_provenance = Provenance::kAssumed;
  std::vector<std::string> notes;  // e.g. "frames start at 27"
};

// Returns one line of text: "unit 0.01 m (deduced), y up (stated); <notes>".
std::string Describe(const SourceReport& report);

// "given", "stated", ...
std::string_view NameOf(Provenance provenance);
// "y", "-z", ...
std::string_view NameOf(UpAxis up);

// Overrides by the caller. Numbers must be finite and positive.
struct ReadOptions {
  std::optional<double> metres_per_unit;
  std::optional<UpAxis> up_axis;
  std::optional<double> frame_rate_hz;  // AMC has none: default 120, reported as assumed
  std::string take = {};                // of a file with several; empty: its only one
};

// One of several takes of a file.
struct TakeInfo {
  std::string name;
  double duration_s = 0;
};

struct MotionFile {
  Motion motion;
  SourceReport report;
  std::string take = {};             // name of the take that was asked for; empty: none was
  std::vector<TakeInfo> takes = {};  // of a file with several, in its order; not stored
};

// A file in memory: `name` appears in error messages ("walk.bvh:12: expected ...").
struct SourceFile {
  std::string_view name;
  std::string_view bytes;
};

// INVALID_ARGUMENT for a number out of range, or for a take of a format without takes.
absl::Status CheckReadOptions(FileFormat format, std::string_view file_name,
                              const ReadOptions& options);

// Reads one motion file. `skeleton` is the ASF of an AMC, for which it is required, or the URDF of
// a CSV; unused otherwise.
//
// Every error is INVALID_ARGUMENT and names file, line (byte offset for C3D) and the expected
// content. So is a format that only motiondb-import reads (NeedsImport). A truncated file is an
// error unless the rest is a complete file. Sizes in the file are checked against its length before
// memory is allocated.
absl::StatusOr<MotionFile> ReadMotionFile(FileFormat format, SourceFile file,
                                          std::optional<SourceFile> skeleton = std::nullopt,
                                          const ReadOptions& options = {});

// Returns the maximum memory (bytes) that ReadMotionFile uses, including its result. O(file size).
std::int64_t MaxBytesToRead(FileFormat format, SourceFile file,
                            std::optional<SourceFile> skeleton = std::nullopt);

inline constexpr int kMaxFileJoints = 2000;  // including end sites and tips of bones

}  // namespace motiondb::core
