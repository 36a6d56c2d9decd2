#include "storage/postgres/postgres_connector.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <random>

#include "core/motion/error.h"
#include "storage/postgres/postgres_conversion.h"
#include "storage/store_url.h"

namespace motiondb::storage {
namespace {

constexpr std::string_view kPooled = "pooled=";

struct FreeOptions {
  void operator()(PQconninfoOption* options) const { PQconninfoFree(options); }
};

// Removes the parameter `pooled` from the URL.
absl::Status TakePooled(PostgresAddress& address) {
  const std::size_t question = address.url.find('?');
  if (question == std::string::npos) return absl::OkStatus();
  const std::string query = address.url.substr(question + 1);
  address.url.resize(question);
  char separator = '?';
  for (std::size_t begin = 0; begin <= query.size();) {
    const std::size_t end = std::min(query.find('&', begin), query.size());
    const std::string parameter = query.substr(begin, end - begin);
    begin = end + 1;
    if (parameter.starts_with(kPooled)) {
      const std::string value = parameter.substr(kPooled.size());
      if (value != "0" && value != "1") {
        return core::InvalidArgument("the store's parameter 'pooled' must be 0 or 1");
      }
      address.pooled = value == "1";
    } else if (!parameter.empty()) {
      address.url += separator + parameter;
      separator = '&';
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PostgresAddress> ParsePostgresUrl(std::string_view url) {
  PostgresAddress address{.url = std::string(url)};
  if (!IsPostgresUrl(url)) {
    return core::InvalidArgument("the URL of a PostgreSQL store begins with postgresql://");
  }
  MOTIONDB_RETURN_IF_ERROR(TakePooled(address));
  char* error = nullptr;
  const std::unique_ptr<PQconninfoOption, FreeOptions> options(
      PQconninfoParse(address.url.c_str(), &error));
  PQfreemem(error);  // it can contain the password
  if (options == nullptr) {
    return core::InvalidArgument(
        "cannot parse the URL of the PostgreSQL store (it is not shown: it may contain a "
        "password); expected postgresql://[user[:password]@][host][:port][/database][?parameters]");
  }
  std::string host;
  std::string port;
  std::string database;
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (option->val == nullptr) continue;
    const std::string_view keyword = option->keyword;
    if (keyword == "host") host = option->val;
    if (keyword == "port") port = option->val;
    if (keyword == "dbname") database = option->val;
  }
  address.name =
      fmt::format("postgresql://{}{}{}/{}", host, port.empty() ? "" : ":", port, database);
  return address;
}

namespace {

constexpr std::chrono::milliseconds kMinDelay{50};
constexpr std::chrono::milliseconds kMaxDelay{2000};
constexpr char kConnectSeconds[] = "5";
// Without data for this time, Await checks whether PostgreSQL hangs. A limit of the whole wait
// would be wrong: a long statement, or one that waits for a lock, sends nothing either. The
// timeouts of TCP find lost peers, but not a stopped process, whose system continues to
// acknowledge.
constexpr std::chrono::seconds kMaxIdleTime{5};
constexpr int kPollMilliseconds = 1000;

}  // namespace

PostgresConnector::PostgresConnector(PostgresAddress address)
    : address_(std::move(address)),
      importer_(
          fmt::format("import/{:08x}{:08x}", std::random_device()(), std::random_device()())) {}

absl::Status PostgresConnector::Unreachable(std::string_view why) const {
  return core::WithReason(kStoreUnreachable, absl::UnavailableError(fmt::format(
                                                 "the store {}: {}", address_.name, why)));
}

absl::StatusOr<SessionHandle> PostgresConnector::Connect() {
  {
    const MutexLock lock(mutex_);
    // One attempt at a time: if PostgreSQL hangs, each takes some seconds of its thread.
    if (delay_ > Clock::duration::zero() && (is_connecting_ || Clock::now() < next_attempt_)) {
      return Unreachable("the connection is lost; it is tried again soon");
    }
    is_connecting_ = true;
  }
  auto connected = TryToConnect(address_.read_only ? "any" : "read-write");
  ++(connected.ok() ? opened_ : failed_);
  const MutexLock lock(mutex_);
  is_connecting_ = false;
  if (connected.ok()) {
    delay_ = Clock::duration::zero();
    hangs_ = false;
  } else {
    delay_ = std::clamp<Clock::duration>(2 * delay_, kMinDelay, kMaxDelay);
    next_attempt_ = Clock::now() + delay_;
  }
  return connected;
}

absl::Status PostgresConnector::Await(PGconn* session, const core::Cancelled& cancelled,
                                      Awaited awaited) {
  auto heard = Clock::now();
  while (true) {
    // PQgetResult returns the errors of these calls.
    const int unsent = PQflush(session);
    const bool done = awaited == Awaited::kSent ? unsent == 0 : PQisBusy(session) == 0;
    if (unsent < 0 || done) return absl::OkStatus();
    const auto events = static_cast<short>(unsent > 0 ? POLLIN | POLLOUT : POLLIN);
    pollfd ready{PQsocket(session), events, 0};
    if (poll(&ready, 1, kPollMilliseconds) > 0) {
      heard = Clock::now();
      if (PQconsumeInput(session) == 0) return absl::OkStatus();
      continue;
    }
    if (cancelled && cancelled()) {
      return absl::CancelledError("cancelled while the store did not respond");
    }
    if (Clock::now() - heard < kMaxIdleTime) continue;
    if (!Responds(session)) return Unreachable("PostgreSQL does not respond");
    heard = Clock::now();
  }
}

bool PostgresConnector::Responds(const PGconn* session) {
  if (hangs_) return false;
  // The URL can have several hosts: that of the session counts. Empty values have no effect.
  const char* const address = PQhostaddr(session);
  const std::array<const char*, 6> keywords = {"connect_timeout", "dbname", "host",
                                               "hostaddr",        "port",   nullptr};
  const std::array<const char*, 6> values = {kConnectSeconds, address_.url.c_str(),
                                             PQhost(session), address == nullptr ? "" : address,
                                             PQport(session), nullptr};
  const PGPing found = PQpingParams(keywords.data(), values.data(), /*expand_dbname=*/1);
  if (found != PQPING_NO_RESPONSE) return true;
  const MutexLock lock(mutex_);
  hangs_ = true;
  delay_ = kMaxDelay;
  next_attempt_ = Clock::now() + delay_;
  return false;
}

bool PostgresConnector::IsRefused() const {
  if (address_.pooled || TryToConnect("any").ok()) return false;
  const std::array<const char*, 3> keywords = {"connect_timeout", "dbname", nullptr};
  const std::array<const char*, 3> values = {kConnectSeconds, address_.url.c_str(), nullptr};
  return PQpingParams(keywords.data(), values.data(), /*expand_dbname=*/1) == PQPING_OK;
}

absl::StatusOr<SessionHandle> PostgresConnector::TryToConnect(const char* attributes) const {
  // Parameters before the URL are defaults that it may change; those after it are fixed.
  static constexpr std::array<const char*, 9> kKeywords = {"connect_timeout",
                                                           "tcp_user_timeout",
                                                           "keepalives_idle",
                                                           "keepalives_interval",
                                                           "fallback_application_name",
                                                           "target_session_attrs",
                                                           "dbname",
                                                           "client_encoding",
                                                           nullptr};
  const std::array<const char*, 9> values = {
      kConnectSeconds,      "30000", "30",   "10", "motiondb", attributes,
      address_.url.c_str(), "UTF8",  nullptr};
  SessionHandle session(PQconnectdbParams(kKeywords.data(), values.data(), /*expand_dbname=*/1));
  if (session == nullptr) return absl::ResourceExhaustedError("no memory for a connection");
  if (PQstatus(session.get()) != CONNECTION_OK) {
    return Unreachable(std::string(PostgresError(session.get(), nullptr).message()));
  }
  const auto ignore = [](void*, const char*) {};
  PQsetNoticeProcessor(session.get(), ignore, nullptr);
  if (PQsetnonblocking(session.get(), 1) != 0) return Unreachable("the session was lost");
  return session;
}

}  // namespace motiondb::storage
