#include "client/cli/plot/picture_file.h"

#include <fmt/format.h>

#include "client/cli/motion_file.h"
#include "client/cli/usage/usage_error.h"
#include "client/output_file.h"

namespace motiondb::client {

absl::Status CheckPictureFile(const char* option, const std::string& file) {
  if (file.empty() || HasExtension(file, ".svg") || HasExtension(file, ".png")) {
    return absl::OkStatus();
  }
  return UsageError(fmt::format("{} {}: expected FILE.svg or FILE.png", option, file));
}

absl::Status WritePicture(const std::filesystem::path& file, const Canvas& canvas) {
  if (!HasExtension(file, ".png")) return WriteFileAtomically(file, SvgOf(canvas));
  const auto png = PngOf(canvas);
  if (!png.ok()) return png.status();
  return WriteFileAtomically(file, *png);
}

}  // namespace motiondb::client
