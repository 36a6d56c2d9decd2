#include "storage/postgres/postgres_connector.h"

#include <algorithm>
#include <array>

#include "core/motion/error.h"
#include "storage/postgres/postgres_error.h"
#include "storage/store_url.h"

namespace motiondb::storage {
namespace {

constexpr std::chrono::milliseconds kMinDelay{50};
constexpr std::chrono::milliseconds kMaxDelay{2000};

}  // namespace

absl::Status PostgresConnector::Unreachable(std::string_view why) const {
  return core::WithReason(kStoreUnreachable, absl::UnavailableError(fmt::format(
                                                 "the store {}: {}", address_.name, why)));
}

absl::StatusOr<SessionHandle> PostgresConnector::Connect() {
  {
    const MutexLock lock(mutex_);
    if (delay_ > Clock::duration::zero() && Clock::now() < next_attempt_) {
      return Unreachable("the connection is lost; it is tried again soon");
    }
  }
  auto connected = TryToConnect();
  const MutexLock lock(mutex_);
  if (connected.ok()) {
    delay_ = Clock::duration::zero();
  } else {
    delay_ = std::clamp<Clock::duration>(2 * delay_, kMinDelay, kMaxDelay);
    next_attempt_ = Clock::now() + delay_;
  }
  return connected;
}

absl::StatusOr<SessionHandle> PostgresConnector::TryToConnect() const {
  // Parameters before the URL are defaults that it may change; those after it are fixed.
  static constexpr std::array<const char*, 8> kKeywords = {
      "connect_timeout",           "tcp_user_timeout", "keepalives_idle", "keepalives_interval",
      "fallback_application_name", "dbname",           "client_encoding", nullptr};
  const std::array<const char*, 8> values = {
      "5", "30000", "30", "10", "motiondb", address_.url.c_str(), "UTF8", nullptr};
  SessionHandle session(PQconnectdbParams(kKeywords.data(), values.data(), /*expand_dbname=*/1));
  if (session == nullptr) return absl::ResourceExhaustedError("no memory for a connection");
  if (PQstatus(session.get()) != CONNECTION_OK) {
    return Unreachable(std::string(PostgresError(session.get(), nullptr).message()));
  }
  const auto ignore = [](void*, const char*) {};
  PQsetNoticeProcessor(session.get(), ignore, nullptr);
  return session;
}

}  // namespace motiondb::storage
