// Reads and checks what TLS is made of: PEM files. Safe to call from any thread.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace motiondb::server {

struct TlsFiles {
  std::string certificate;  // the server's, with what lies between it and its authority
  std::string key;          // of the certificate
  std::string client_ca;    // who signs the clients' certificates; empty: none is asked for

  bool enabled() const { return !certificate.empty(); }
};

// What they hold.
struct TlsTexts {
  std::string certificate;
  std::string key;
  std::string client_ca;
  // When the first certificate that connections need ends, Unix time in seconds: the server's, one
  // between it and its authority, or one of the authorities of clients.
  std::int64_t end_time_s = 0;
  std::string first_to_end;  // the file that has it

  bool operator==(const TlsTexts&) const = default;
};

// INVALID_ARGUMENT, naming the file: it cannot be read, holds no certificate or key, or the key is
// not that of the certificate.
absl::StatusOr<TlsTexts> ReadTlsFiles(const TlsFiles& files);

}  // namespace motiondb::server
