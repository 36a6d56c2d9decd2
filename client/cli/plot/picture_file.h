// Files of pictures, which options of commands name.
#pragma once

#include <filesystem>
#include <string>

#include "absl/status/status.h"
#include "client/cli/plot/canvas.h"

namespace motiondb::client {

// The type name of an option that names a picture.
inline constexpr char kPictureFile[] = "FILE.svg|png";

// Returns UsageError, with the name of the option, unless the file is FILE.svg or FILE.png. An
// empty name is accepted.
absl::Status CheckPictureFile(const char* option, const std::string& file);

// Writes the picture in the format of the file's extension (WriteFileAtomically, PngOf).
absl::Status WritePicture(const std::filesystem::path& file, const Canvas& canvas);

}  // namespace motiondb::client
