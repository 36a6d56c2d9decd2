// Looks ahead to the end of the first certificate that connections need. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace motiondb::server {

class CertificateEnd {
 public:
  // Takes the end of a certificate that is new, Unix time in seconds.
  using Tell = std::function<void(std::int64_t end_time_s)>;

  // `tell` may be empty.
  explicit CertificateEnd(Tell tell);

  // At `now_s` it is one in `file` that ends at `end_time_s`, both Unix time in seconds. Logs a
  // warning from 14 days before on, once for each certificate.
  void Look(const std::string& file, std::int64_t end_time_s, std::int64_t now_s);

 private:
  Tell tell_;
  std::int64_t end_time_s_ = 0;  // as it was told
  bool warned_ = false;
};

}  // namespace motiondb::server
