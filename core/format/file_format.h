// The formats of motion files.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::core {

enum class FileFormat { kBvh, kAmc, kTrc, kC3d, kCsv, kNpz, kFbx, kGltf, kCollada };

// What motiondb knows about a format.
struct FormatInfo {
  FileFormat format;
  std::string_view name;         // lower case, in the store and on the command line
  std::string_view extensions;   // ".gltf .glb .vrm"
  std::string_view description;  // what is read
  std::string_view skeleton;     // extension of the skeleton file that it needs; empty: none
  bool is_read_here;             // by ReadMotionFile; false: only by motiondb-import
  bool has_takes;                // a file can have several
  bool is_written;               // by WriteMotion
};

// All formats, in the order of FileFormat.
std::span<const FormatInfo> KnownFormats();
const FormatInfo& InfoOf(FileFormat format);

// Returns the format for a file's extension (any case), before a ".gz" if it has that.
// INVALID_ARGUMENT lists the known ones.
absl::StatusOr<FileFormat> FormatOfPath(std::string_view path);

// Returns the extension of a written file: ".bvh", ".glb".
std::string_view WrittenExtension(FileFormat format);

// Whether only motiondb-import reads the file: by its format, or because it is compressed (gzip).
bool NeedsImport(FileFormat format, std::string_view bytes);

}  // namespace motiondb::core
