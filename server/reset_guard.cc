#include "server/reset_guard.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <malloc.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/connection_figures.h"

namespace motiondb::server {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks{100};
// What a look costs grows with the connections, so they are only asked when there may be a reason.
constexpr std::int64_t kUnansweredBetweenLooks = 1000;

// The other end of a connection, as ConnectionFigures has it; nothing for other descriptors.
std::pair<std::string, int> ClientOf(int descriptor) {
  sockaddr_storage other{};
  socklen_t size = sizeof(other);
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&other), &size) != 0) return {};
  if (other.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(other);
    return {std::string(reinterpret_cast<const char*>(&v4.sin_addr), 4), ntohs(v4.sin_port)};
  }
  if (other.ss_family != AF_INET6) return {};
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(other);
  const std::string address(reinterpret_cast<const char*>(&v6.sin6_addr), 16);
  return {IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr) ? address.substr(12) : address, ntohs(v6.sin6_port)};
}

// With all that came and was not read: after a shutdown gRPC would read megabytes of it.
void Disconnect(int descriptor) {
  sockaddr nowhere{};
  nowhere.sa_family = AF_UNSPEC;
  connect(descriptor, &nowhere, sizeof(nowhere));
}

// gRPC has the descriptor and does not tell it, so it is looked for.
void End(const ConnectionFigures& connection) {
  if (connection.address.empty()) return;  // as ClientOf says of what is no connection
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const std::string name = entry.path().filename();
    int number = -1;
    std::from_chars(name.data(), name.data() + name.size(), number);
    // One of our own for the same: gRPC may close its number, and open something else by it.
    const int descriptor = dup(number);
    if (descriptor < 0) continue;
    if (ClientOf(descriptor) == std::pair(connection.address, connection.port)) {
      Disconnect(descriptor);
    }
    close(descriptor);
  }
}

std::string NameOf(const ConnectionFigures& connection) {
  char text[INET6_ADDRSTRLEN] = "";
  const bool v4 = connection.address.size() == 4;
  inet_ntop(v4 ? AF_INET : AF_INET6, connection.address.data(), text, sizeof(text));
  return fmt::format(fmt::runtime(v4 ? "{}:{}" : "[{}]:{}"), text, connection.port);
}

}  // namespace

ResetGuard::ResetGuard(CallLimit most)
    : most_(most), unanswered_calls_(CountUnansweredCalls()), thread_([this] { Run(); }) {}

ResetGuard::~ResetGuard() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ends_.notify_one();
  thread_.join();
}

void ResetGuard::Run() {
  std::unique_lock lock(mutex_);
  while (!ends_.wait_for(lock, kBetweenLooks, [this] { return ending_; })) Look();
}

void ResetGuard::Look() {
  const std::int64_t unanswered = CountUnansweredCalls();
  unanswered_calls_ = std::min(unanswered_calls_, unanswered);  // another server may have ended
  if (unanswered - unanswered_calls_ < kUnansweredBetweenLooks) {
    // A flood is over; its memory is free, but the C library keeps it.
    if (std::exchange(ended_some_, false)) malloc_trim(0);
    return;
  }
  unanswered_calls_ = unanswered;
  std::vector<ConnectionFigures> connections = ListConnections();
  std::ranges::sort(connections, std::greater(), &ConnectionFigures::kept_calls);
  std::int64_t kept = 0;
  for (const ConnectionFigures& connection : connections) kept += connection.kept_calls;
  for (const ConnectionFigures& connection : connections) {
    if (kept <= most_.in_all || connection.kept_calls <= most_.per_client) return;
    spdlog::warn("{}: its connection is ended: it broke calls off until gRPC kept {} of them",
                 NameOf(connection), connection.kept_calls);
    End(connection);
    ended_some_ = true;
    kept -= connection.kept_calls;
  }
}

}  // namespace motiondb::server
