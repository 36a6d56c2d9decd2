#include "server/security/certificate_end.h"

#include <fmt/chrono.h>
#include <spdlog/spdlog.h>

#include <ctime>
#include <utility>

namespace motiondb::server {
namespace {

// As in the alert of deploy/prometheus.
constexpr std::int64_t kSoonSeconds = std::int64_t{14} * 24 * 3600;

}  // namespace

CertificateEnd::CertificateEnd(Tell tell) : tell_(std::move(tell)) {}

void CertificateEnd::Look(const std::string& file, std::int64_t end_time_s, std::int64_t now_s) {
  if (end_time_s != end_time_s_) {
    end_time_s_ = end_time_s;
    warned_ = false;
    if (tell_) tell_(end_time_s);
  }
  if (warned_ || end_time_s - now_s > kSoonSeconds) return;
  warned_ = true;
  spdlog::warn(
      "{}: a certificate in it ends on {:%Y-%m-%d %H:%M} UTC, and then no client connects that "
      "needs it: put a new one in its place, which is taken while the server runs",
      file, fmt::gmtime(static_cast<std::time_t>(end_time_s)));
}

}  // namespace motiondb::server
