#include "server/connection_acceptor.h"

#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "core/motion/error.h"
#include "server/observability/listen_on.h"

namespace motiondb::server {
namespace {

using std::chrono::steady_clock;

// Each connection costs gRPC some 20 KB, those that are silent too.
constexpr rlim_t kMostDescriptors = 65'536;
constexpr int kForOthers = 64;  // descriptors: files of the store, threads' wake-ups, HTTP
constexpr std::chrono::milliseconds kRest{100};
constexpr std::chrono::minutes kBetweenWarnings{1};

// Below which the descriptor of a connection must be.
int MostDescriptors() {
  rlimit limit{};
  const bool known = getrlimit(RLIMIT_NOFILE, &limit) == 0;
  const auto most =
      static_cast<int>(known ? std::min(limit.rlim_cur, kMostDescriptors) : rlim_t{1024});
  return most - std::min(kForOthers, most / 4);
}

bool LacksResources(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

}  // namespace

void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = std::max(limit.rlim_cur, std::min(limit.rlim_max, kMostDescriptors));
  setrlimit(RLIMIT_NOFILE, &limit);
}

absl::StatusOr<std::unique_ptr<ConnectionAcceptor>> ConnectionAcceptor::Start(
    const std::string& listen, Take take) {
  std::unique_ptr<ConnectionAcceptor> acceptor(new ConnectionAcceptor(std::move(take)));
  MOTIONDB_RETURN_IF_ERROR(acceptor->Listen(listen));
  for (Acceptor& each : acceptor->acceptors_) acceptor->Await(each);
  acceptor->thread_ = std::thread([context = &acceptor->context_] { context->run(); });
  return acceptor;
}

ConnectionAcceptor::ConnectionAcceptor(Take take)
    : take_(std::move(take)), most_descriptors_(MostDescriptors()) {}

ConnectionAcceptor::~ConnectionAcceptor() {
  context_.stop();
  if (thread_.joinable()) thread_.join();
}

int ConnectionAcceptor::port() const { return acceptors_.front().local_endpoint().port(); }

absl::Status ConnectionAcceptor::Listen(const std::string& listen) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<std::string> hosts, AddressesOf(listen));
  std::string port = listen.substr(listen.rfind(':') + 1);
  absl::Status failed;
  for (const std::string& host : hosts) {
    Acceptor acceptor(context_);
    const absl::Status listening = ListenOn(fmt::format("{}:{}", host, port), acceptor);
    if (absl::IsNotFound(listening)) {  // a name may have more addresses than the machine
      failed = listening;
      continue;
    }
    MOTIONDB_RETURN_IF_ERROR(listening);
    acceptor.non_blocking(true);
    port = std::to_string(acceptor.local_endpoint().port());
    acceptors_.push_back(std::move(acceptor));
  }
  return acceptors_.empty() ? failed : absl::OkStatus();
}

void ConnectionAcceptor::Await(Acceptor& acceptor) {
  acceptor.async_wait(Acceptor::wait_read, [this, &acceptor](const auto& error) {
    if (!error) Accept(acceptor);
  });
}

void ConnectionAcceptor::Accept(Acceptor& acceptor) {
  const int connection =
      accept4(acceptor.native_handle(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (connection >= 0) {
    Admit(connection, acceptor);
  } else if (LacksResources(errno)) {
    std::this_thread::sleep_for(kRest);
  }
  Await(acceptor);
}

void ConnectionAcceptor::Admit(int connection, Acceptor& acceptor) {
  // A descriptor is the lowest that is free, so its number is how many are in use at least.
  if (connection < most_descriptors_) {
    const int on = 1;
    setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
    return take_(connection, acceptor.native_handle());
  }
  close(connection);
  const auto now = steady_clock::now();
  if (warned_ != steady_clock::time_point() && now - warned_ < kBetweenWarnings) return;
  warned_ = now;
  spdlog::warn(
      "connections are refused: {} descriptors are in use, as many as connections may have of "
      "those that the process may open (ulimit -n, LimitNOFILE)",
      most_descriptors_);
}

}  // namespace motiondb::server
