// A file that is written whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

#include "absl/status/status.h"

namespace motiondb::client {

// Replaces what lies there. UNKNOWN, naming the file, if it cannot be written: then what lay there
// still does.
absl::Status WriteWholeFile(const std::filesystem::path& path, std::string_view bytes);

}  // namespace motiondb::client
