#include "client/cli/whole_file.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

namespace motiondb::client {

absl::Status WriteWholeFile(const std::filesystem::path& path, const std::string& bytes) {
  const std::filesystem::path partial = path.string() + ".partial";
  std::ofstream file(partial, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code error;
  if (file) {
    std::filesystem::rename(partial, path, error);
    if (!error) return absl::OkStatus();
  }
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  return absl::UnknownError(
      fmt::format("{}: {}", path.string(), error ? error.message() : "cannot be written"));
}

}  // namespace motiondb::client
