// Motion files on disk, their formats, their skeleton files, and the options that describe them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "absl/status/statusor.h"

namespace CLI {
class App;
}  // namespace CLI

namespace motiondb::v1 {
enum FileFormat : int;
class Observation;
class SourceConventions;
}  // namespace motiondb::v1

namespace motiondb::client {

// Command line options about a file; 0 or empty: not set.
struct SourceOptions {
  std::string skeleton;
  double metres_per_unit = 0;
  std::string up_axis;
  double frame_rate_hz = 0;
  double leg_length_m = 0;
  bool force = false;  // accept a body that no person has
  std::string take;
};

// Bind the options to a command.
void AddSourceOptions(CLI::App& command, SourceOptions& options);
void AddForceOption(CLI::App& command, SourceOptions& options);

v1::SourceConventions Conventions(const SourceOptions& options);

// Returns whether the file has the extension `expected`, such as ".amc", ignoring case.
bool HasExtension(const std::filesystem::path& file, const std::string& expected);

// Returns the ASF file in the folder of an AMC file whose name (without extension) is the longest
// prefix of the AMC's name. NOT_FOUND: there is none.
absl::StatusOr<std::filesystem::path> FindSkeletonBeside(const std::filesystem::path& amc);

// Returns the skeleton file of a motion file: for AMC `given`, or the result of FindSkeletonBeside;
// for CSV `given`, or the only URDF file in its folder, if there is one; empty for other formats.
absl::StatusOr<std::filesystem::path> SkeletonFor(const std::filesystem::path& file,
                                                  const std::filesystem::path& given);

// Reads a file for one message. NOT_FOUND: no such file. INVALID_ARGUMENT: a folder, or more than
// the maximum of a message, 64 MiB. UNKNOWN: it cannot be read.
absl::StatusOr<std::string> ReadFileBytes(const std::filesystem::path& path);

// As ReadFileBytes, for a file that the server stores as text. INVALID_ARGUMENT if it is not UTF-8.
absl::StatusOr<std::string> ReadTextFile(const std::filesystem::path& path);

// Returns an observation with the contents of the file and of its skeleton file.
absl::StatusOr<v1::Observation> ObservationFromFile(const std::filesystem::path& file,
                                                    const SourceOptions& options);

// Formats of motion files, by their extensions. motiondb-import knows all about them.

// Returns the extension in lower case, without a ".gz" after it: ".bvh" of "walk.BVH.gz". Also of
// skeleton files.
std::string MotionExtension(const std::filesystem::path& file);

// Whether a file has the extension of a motion file.
bool IsMotionFile(const std::filesystem::path& file);

// ".bvh, .amc, ...": all extensions.
std::string MotionExtensions();

// Returns the format that is written with a name or extension: "bvh", ".glb". INVALID_ARGUMENT
// lists the known ones.
absl::StatusOr<v1::FileFormat> WrittenFormat(const std::string& name);

// Its name in requests of motiondb-import: "gltf".
std::string NameOfFormat(v1::FileFormat format);

// Names for `--as`: "bvh|trc|...".
std::string WrittenFormatNames();

}  // namespace motiondb::client
