// Small files whose paths the operator configures: the admin token, and the PEM files of TLS.
#pragma once

#include <sys/stat.h>

#include <cstdint>
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

// Paths of the PEM files of TLS.
struct TlsFiles {
  std::string certificate;  // of the server, followed by intermediate certificates
  std::string key;          // private key of the certificate
  std::string client_ca;    // authorities of client certificates; empty: clients need none

  bool enabled() const { return !certificate.empty(); }
};

// The contents of TlsFiles.
struct TlsContents {
  std::string certificate;
  std::string key;
  std::string client_ca;
  // Unix time, s, at which the first of all these certificates expires: server, intermediate, or
  // client authority.
  std::int64_t end_time_s = 0;
  std::string first_to_end;  // path of the file with that certificate

  bool operator==(const TlsContents&) const = default;
};

// Reads and checks the files, and returns their contents. Returns INVALID_ARGUMENT with the path if
// a file cannot be read, has no certificate or key, has an expired certificate, or the key does not
// match the certificate.
absl::StatusOr<TlsContents> ReadTlsFiles(const TlsFiles& files);

}  // namespace motiondb::server
