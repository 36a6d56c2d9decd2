// Small files whose paths the operator configures, and checks of files with secrets.
#pragma once

#include <sys/stat.h>

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// Returns the content. Returns INVALID_ARGUMENT with the path and the reason if it cannot be read.
absl::StatusOr<std::string> ReadTextFile(const std::string& path);

// Returns the fault in the mode of a file with a secret; empty if the mode is safe.
inline std::string_view ModeFault(mode_t mode) {
  if ((mode & S_IROTH) != 0) return "everybody on this machine can read it";
  if ((mode & S_IWOTH) != 0) return "everybody on this machine can write it";
  if ((mode & S_IWGRP) != 0) return "its group can write it";
  return "";
}

// The expected modes, for error messages.
inline constexpr char kSecretModes[] = "0600 or 0640";

// Returns the token in the admin token file, without surrounding white space. Returns
// INVALID_ARGUMENT with the path if the file cannot be read, if its mode has a fault (ModeFault),
// or if the token has fewer than 20 characters or non-printable or non-ASCII characters. The error
// never contains the token.
absl::StatusOr<std::string> ReadAdminToken(const std::string& path);

}  // namespace motiondb::server
