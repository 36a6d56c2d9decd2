// Reads and checks the PEM files of TLS.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace motiondb::server {

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

// Returns the contents of the files. Returns INVALID_ARGUMENT with the path if a file cannot be
// read, has no certificate or key, has an expired certificate, or the key does not match the
// certificate.
absl::StatusOr<TlsContents> ReadTlsFiles(const TlsFiles& files);

}  // namespace motiondb::server
