// A motion file on disk, with the skeleton file that it needs and what the user knows about it.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "absl/status/statusor.h"

namespace motiondb::v1 {
class Observation;
class SourceConventions;
}  // namespace motiondb::v1

namespace motiondb::client {

// What the command line says about a file.
struct SourceOptions {
  std::string skeleton;
  double metres_per_unit = 0;
  std::string up_axis;
  double frame_rate_hz = 0;
  double leg_length_m = 0;
};

// Binds them to a command.
void AddSourceOptions(CLI::App& command, SourceOptions& options);

v1::SourceConventions Conventions(const SourceOptions& options);

// True for a file that has this extension, ".amc", in upper or lower case.
bool HasExtension(const std::filesystem::path& file, const std::string& expected);

// True for a file whose joints come in a file of their own: AMC.
bool NeedsSkeleton(const std::filesystem::path& file);

// The ASF file beside an AMC file: the longest ASF name (without extension) that begins the AMC's
// name. NOT_FOUND if there is none.
absl::StatusOr<std::filesystem::path> FindSkeletonBeside(const std::filesystem::path& amc);

// The skeleton file for a motion file: `given`, or the one beside it; empty where none is needed.
absl::StatusOr<std::filesystem::path> SkeletonFor(const std::filesystem::path& file,
                                                  const std::filesystem::path& given);

// All bytes of a file that goes into one message. NOT_FOUND if there is none; INVALID_ARGUMENT for
// a folder, and for more than a message may hold, 64 MiB; UNKNOWN, saying why, if it cannot be
// read.
absl::StatusOr<std::string> ReadFileBytes(const std::filesystem::path& path);

// An observation that carries the whole file, and its skeleton.
absl::StatusOr<v1::Observation> ObservationFromFile(const std::filesystem::path& file,
                                                    const SourceOptions& options);

}  // namespace motiondb::client
