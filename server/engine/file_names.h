// What a file's name says. Safe to call from any thread.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::server {

// Without folders, of either kind of slash.
std::string WithoutFolders(std::string_view path);

// The clip id that a file's name (without folders) suggests: its stem, with '_' for each character
// that an id cannot have, and short enough for a number to be added; "clip" where nothing is left.
std::string ClipIdFromFileName(std::string_view file_name);

}  // namespace motiondb::server
