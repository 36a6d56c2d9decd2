// Looks ahead to the end of the server's certificate: whoever connects after it is refused by every
// client. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace motiondb::server {

class CertificateEnd {
 public:
  // Takes the end of a certificate that is new, Unix time in seconds.
  using Tell = std::function<void(std::int64_t end_time_s)>;

  // Of what `file` holds, for the log. `tell` may be empty.
  CertificateEnd(std::string file, Tell tell);

  // The one that is served at `now_s` ends at `end_time_s`, both Unix time in seconds. Logs a
  // warning from 14 days before on, once for each certificate.
  void Look(std::int64_t end_time_s, std::int64_t now_s);

 private:
  std::string file_;
  Tell tell_;
  std::int64_t end_time_s_ = 0;  // as it was told
  bool warned_ = false;
};

}  // namespace motiondb::server
