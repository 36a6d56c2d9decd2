// Files whose content is to be known to few. Safe to use from any thread.
#pragma once

#include <sys/stat.h>

#include <string_view>

namespace motiondb::server {

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

}  // namespace motiondb::server
