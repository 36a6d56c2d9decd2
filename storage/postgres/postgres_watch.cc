#include "storage/postgres/postgres_watch.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <string>
#include <system_error>
#include <utility>

#include "core/motion/error.h"
#include "storage/postgres/postgres_conversion.h"
#include "storage/postgres/postgres_statement.h"

namespace motiondb::storage {
namespace {

constexpr int kRetryMilliseconds = 100;
// PostgreSQL sends nothing to a listener that waits: the system finds a lost peer (keepalives).
constexpr int kForever = -1;

struct FreeNotification {
  void operator()(PGnotify* notification) const { PQfreemem(notification); }
};

// Reads "7 name".
StoreChange ParsePayload(std::string_view payload) {
  const std::size_t space = std::min(payload.find(' '), payload.size());
  StoreChange change;
  std::from_chars(payload.data(), payload.data() + space, change.revision);
  if (space < payload.size()) change.database = FromPostgresText(payload.substr(space + 1));
  return change;
}

}  // namespace

absl::Status PostgresListener::Connect() {
  if (session_ != nullptr) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(SessionHandle session, connector_->Connect());
  PQsendQuery(session.get(), "LISTEN motiondb");
  MOTIONDB_RETURN_IF_ERROR(connector_->Await(session.get(), {}));
  const ResultHandle listening(PQgetResult(session.get()));
  if (PQresultStatus(listening.get()) != PGRES_COMMAND_OK) {
    return connector_->Unreachable(
        std::string(PostgresError(session.get(), listening.get()).message()));
  }
  session_ = std::move(session);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<StoreChange>> PostgresListener::Poll() {
  std::vector<StoreChange> changes;
  if (session_ == nullptr) return connector_->Unreachable("there is no session");
  const bool is_there = PQconsumeInput(session_.get()) != 0;
  while (true) {
    const std::unique_ptr<PGnotify, FreeNotification> next(PQnotifies(session_.get()));
    if (next == nullptr) break;
    changes.push_back(ParsePayload(next->extra));
  }
  if (is_there && PQstatus(session_.get()) == CONNECTION_OK) return changes;
  session_.reset();
  return connector_->Unreachable("the session that listens was lost");
}

std::unique_ptr<StoreWatch> PostgresWatch::Start(const PostgresAddress& address,
                                                 OnStoreChange on_change) {
  std::unique_ptr<PostgresWatch> watch(new PostgresWatch(address, std::move(on_change)));
  if (watch->end_ < 0) return nullptr;
  try {
    watch->thread_ = std::thread([&self = *watch] { self.Run(); });
  } catch (const std::system_error&) {
    return nullptr;
  }
  return watch;
}

PostgresWatch::PostgresWatch(const PostgresAddress& address, OnStoreChange on_change)
    // A connector of its own: its failed attempts do not delay those of the store.
    : listener_(std::make_shared<PostgresConnector>(address)),
      on_change_(std::move(on_change)),
      end_(eventfd(0, EFD_CLOEXEC)) {}

PostgresWatch::~PostgresWatch() {
  if (thread_.joinable()) {
    const std::uint64_t one = 1;
    static_cast<void>(!write(end_, &one, sizeof(one)));
    thread_.join();
  }
  if (end_ >= 0) close(end_);
}

bool PostgresWatch::Wait(int milliseconds) {
  std::array<pollfd, 2> ready{{{end_, POLLIN, 0}, {listener_.socket(), POLLIN, 0}}};
  poll(ready.data(), ready.size(), milliseconds);  // a signal: the next call waits
  return ready[0].revents == 0;
}

void PostgresWatch::Run() {
  bool is_connected = false;
  for (bool goes_on = true; goes_on;) {
    if (!is_connected) {
      is_connected = listener_.Connect().ok();
      // What changed meanwhile was not notified.
      if (is_connected) on_change_({});
    }
    goes_on = Wait(is_connected ? kForever : kRetryMilliseconds);
    if (!goes_on || !is_connected) continue;
    const auto changes = listener_.Poll();
    is_connected = changes.ok();
    if (!is_connected) continue;
    for (const StoreChange& change : *changes) on_change_(change);
  }
}

}  // namespace motiondb::storage
