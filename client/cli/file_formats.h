// Formats of motion files, by their extensions. motiondb-import knows all about them.
#pragma once

#include <motiondb/v1/clip.pb.h>

#include <filesystem>
#include <string>

#include "absl/status/statusor.h"

namespace motiondb::client {

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
