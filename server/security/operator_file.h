// Small files that an operator named, some of whose content is to be known to few. Safe to call
// from any thread.
#pragma once

#include <sys/stat.h>

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// INVALID_ARGUMENT, naming the file and why it cannot be read.
absl::StatusOr<std::string> ReadTextFile(const std::string& path);

// What is wrong with the mode of a file that makes whoever reads or writes it somebody whom others
// trust; empty: nothing.
inline std::string_view FaultOfMode(mode_t mode) {
  if ((mode & S_IROTH) != 0) return "everybody on this machine can read it";
  if ((mode & S_IWOTH) != 0) return "everybody on this machine can write it";
  if ((mode & S_IWGRP) != 0) return "its group can write it";
  return "";
}

// The modes that are right.
inline constexpr char kSecretModes[] = "0600 or 0640";

// The file that holds an administrator's token, for those who set servers up by programs. Safe to
// call from any thread.

// The token, without the white space around it. INVALID_ARGUMENT, naming the file and nothing of
// what it holds: it cannot be read, everybody can read it, others than its owner can write
// it, or its token is shorter than 20 characters or has others than printable ASCII ones.
absl::StatusOr<std::string> ReadAdminToken(const std::string& path);

}  // namespace motiondb::server
