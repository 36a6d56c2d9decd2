#include "server/listen/listener.h"

#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <csignal>
#include <latch>
#include <memory>
#include <new>
#include <utility>

#include "core/motion/error.h"
#include "server/engine/work/thread_pool.h"
#include "server/listen/listen_on.h"

namespace motiondb::server {
namespace {

using boost::asio::ip::tcp;

constexpr rlim_t kMaxDescriptors = 65'536;
constexpr int kOtherDescriptors = 64;  // for files of the store, wake-ups of threads, HTTP
constexpr std::chrono::milliseconds kAcceptRetry{100};  // if no connection can be accepted
constexpr int kMaxAcceptedPerTurn = 64;
constexpr std::chrono::seconds kTick{1};
constexpr std::chrono::minutes kWarningInterval{1};

// Returns the upper limit (exclusive) for the descriptor number of a connection.
int MaxDescriptors() {
  rlimit limit{};
  const bool known = getrlimit(RLIMIT_NOFILE, &limit) == 0;
  const auto max_count =
      static_cast<int>(known ? std::min(limit.rlim_cur, kMaxDescriptors) : rlim_t{1024});
  return max_count - std::min(kOtherDescriptors, max_count / 4);
}

bool LacksResources(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

// Returns an IPv4-mapped IPv6 address as IPv4, so that a client has one address.
tcp::endpoint WithoutV4Mapping(const tcp::endpoint& client) {
  const auto& address = client.address();
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return client;
  return {boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6()),
          client.port()};
}

// Returns the peer in gRPC's format.
std::string PeerOf(const tcp::endpoint& client) {
  const std::string address = client.address().to_string();
  return client.address().is_v6() ? fmt::format("ipv6:[{}]:{}", address, client.port())
                                  : fmt::format("ipv4:{}:{}", address, client.port());
}

// Returns the oldest connection without a call; null if there is none.
std::shared_ptr<ClientConnection> OldestIdle(
    const std::multiset<std::shared_ptr<ClientConnection>>& connections) {
  std::shared_ptr<ClientConnection> oldest;
  for (const auto& connection : connections) {
    if (connection == nullptr || connection->calls() > 0) continue;
    if (oldest == nullptr || connection->began() < oldest->began()) oldest = connection;
  }
  return oldest;
}

// A client whose machine is gone answers no probe. Its connection ends after two minutes, and with
// it streams that have nothing to send.
void SetSocketOptions(int descriptor) {
  const auto set = [&](int level, int option, int value) {
    setsockopt(descriptor, level, option, &value, sizeof(value));
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 60);   // s
  set(IPPROTO_TCP, TCP_KEEPINTVL, 15);  // s
  set(IPPROTO_TCP, TCP_KEEPCNT, 4);
}

}  // namespace

void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = std::max(limit.rlim_cur, std::min(limit.rlim_max, kMaxDescriptors));
  setrlimit(RLIMIT_NOFILE, &limit);
}

absl::StatusOr<std::unique_ptr<Listener>> Listener::Start(const std::string& listen,
                                                          const ListenerOptions& options,
                                                          MakeConnection make,
                                                          ConnectionMeter& meter) {
  std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes to sockets that the client has closed
  std::unique_ptr<Listener> listener(new Listener(options, std::move(make), meter));
  MOTIONDB_RETURN_IF_ERROR(listener->Listen(listen));
  for (Acceptor& acceptor : listener->acceptors_) listener->Await(acceptor);
  for (const auto& loop : listener->loops_) {
    listener->Tick(*loop);
    loop->thread = std::thread([&context = loop->context] { RunHandlers(context); });
  }
  return listener;
}

Listener::Listener(const ListenerOptions& options, MakeConnection make, ConnectionMeter& meter)
    : options_(options),
      make_(std::move(make)),
      meter_(meter),
      max_descriptors_(MaxDescriptors()),
      loops_(MakeLoops(options.threads)),
      accept_retry_(loops_.front()->context),
      warnings_(1, kWarningInterval) {}

std::vector<std::unique_ptr<Listener::Loop>> Listener::MakeLoops(unsigned threads) {
  std::vector<std::unique_ptr<Loop>> loops(
      std::clamp(std::thread::hardware_concurrency(), 1U, threads));
  for (auto& loop : loops) loop = std::make_unique<Loop>();
  return loops;
}

Listener::~Listener() {
  Close(std::chrono::milliseconds(0));
  for (const auto& loop : loops_) {
    if (loop->thread.joinable()) loop->thread.join();
  }
}

int Listener::port() const { return acceptors_.front().local_endpoint().port(); }

absl::Status Listener::Listen(const std::string& listen) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<std::string> hosts, ResolveAddresses(listen));
  std::string port = listen.substr(listen.rfind(':') + 1);
  absl::Status failed;
  for (const std::string& host : hosts) {
    Acceptor acceptor(loops_.front()->context);
    const absl::Status listening = ListenOn(fmt::format("{}:{}", host, port), acceptor);
    if (absl::IsNotFound(listening)) {  // the host may have addresses of other machines
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

void Listener::Await(Acceptor& acceptor) {
  acceptor.async_wait(Acceptor::wait_read, [this, &acceptor](const auto& error) {
    if (!error && !draining_) Accept(acceptor);  // the wait may end just before a cancel
  });
}

void Listener::Accept(Acceptor& acceptor) {
  if (AcceptWaiting(acceptor)) return AwaitLoops(acceptor);
  accept_retry_.expires_after(kAcceptRetry);
  accept_retry_.async_wait(
      [this, &acceptor](const auto&) {  // also if another acceptor restarted the timer
        if (!draining_) Await(acceptor);
      });
}

// Continues when each loop has begun its connections: a loop that is behind must not collect more.
void Listener::AwaitLoops(Acceptor& acceptor) {
  if (loops_.size() == 1) return Await(acceptor);
  const auto behind = std::make_shared<std::atomic<std::size_t>>(loops_.size());
  for (const auto& loop : loops_) {
    boost::asio::post(loop->context, [this, &acceptor, behind] {
      if (--*behind > 0) return;
      boost::asio::post(loops_.front()->context, [this, &acceptor] {
        if (!draining_) Await(acceptor);
      });
    });
  }
}

// Accepts many waiting clients in one turn of the event loop, so that a busy loop does not leave
// them in the accept queue. False if a resource is exhausted.
bool Listener::AcceptWaiting(Acceptor& acceptor) {
  for (int taken = 0; taken < kMaxAcceptedPerTurn; ++taken) {
    sockaddr_storage address{};
    socklen_t size = sizeof(address);
    const int descriptor = accept4(acceptor.native_handle(), reinterpret_cast<sockaddr*>(&address),
                                   &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (descriptor < 0) {
      if (errno == EAGAIN || errno == EWOULDBLOCK) return true;
      if (LacksResources(errno)) return false;
      continue;
    }
    tcp::endpoint client;
    std::copy_n(reinterpret_cast<const char*>(&address), size,
                reinterpret_cast<char*>(client.data()));
    client.resize(size);
    Admit(descriptor, WithoutV4Mapping(client));
  }
  return true;
}

void Listener::Admit(int descriptor, const tcp::endpoint& client) {
  const std::string address = AttemptSource(client.address().to_string());
  // The kernel assigns the lowest free number, so at least `descriptor` descriptors are in use.
  const char* refusal = descriptor >= max_descriptors_ ? "too many descriptors" : nullptr;
  if (refusal == nullptr && !MakeRoom(address)) refusal = "too many connections";
  if (refusal != nullptr) {
    close(descriptor);
    ++meter_.refused;
    if (!warnings_.Count(refusal)) return;
    return spdlog::warn(
        "connections are refused: reason='{}' peer={} descriptors={} connections_per_address={}; "
        "the process may open more files with ulimit -n or LimitNOFILE",
        refusal, client.address().to_string(), max_descriptors_, options_.connections_per_address);
  }
  SetSocketOptions(descriptor);
  Loop& loop = *loops_[next_loop_++ % loops_.size()];
  if (loops_.size() == 1) return Begin(loop, descriptor, client);  // this thread
  boost::asio::post(loop.context,
                    [this, &loop, descriptor, client] { Begin(loop, descriptor, client); });
}

// Counts a new connection of the address. At a limit it closes another one; false if all have
// calls.
bool Listener::MakeRoom(const std::string& address) {
  const storage::MutexLock lock(mutex_);
  const auto found = by_address_.find(address);
  const std::size_t here = found == by_address_.end() ? 0 : found->second.size();
  if (here >= options_.connections_per_address && !CloseOne(&address)) return false;
  if (count_ >= options_.connections && !CloseOne(nullptr)) return false;
  by_address_[address].insert(nullptr);
  ++count_;
  return true;
}

// Closes the oldest connection without a call, of this address, or, if it is null, of the address
// with the most connections. False if all have calls.
bool Listener::CloseOne(const std::string* address) {
  std::shared_ptr<ClientConnection> oldest;
  Connections* chosen = nullptr;
  const auto consider = [&](Connections& connections) {
    if (chosen != nullptr && connections.size() <= chosen->size()) return;
    const auto idle = OldestIdle(connections);
    if (idle == nullptr) return;
    oldest = idle;
    chosen = &connections;
  };
  if (address != nullptr) {
    consider(by_address_[*address]);
  } else {
    for (auto& [owner, connections] : by_address_) consider(connections);
  }
  if (oldest == nullptr) return false;
  chosen->erase(chosen->find(oldest));
  --count_;
  oldest->Post([oldest] { oldest->Close(); });
  return true;
}

void Listener::Begin(Loop& loop, int descriptor, const tcp::endpoint& client) {
  const std::string address = AttemptSource(client.address().to_string());
  std::shared_ptr<ClientConnection> connection;
  if (closing_) {
    close(descriptor);
    return;
  }
  try {
    tcp::socket socket(loop.context, client.protocol(), descriptor);
    const auto context = options_.tls == nullptr ? nullptr : options_.tls->context();
    connection = make_(
        {loop.context, ByteStream(std::move(socket), context.get(), options_.protocol),
         PeerOf(client), [this, &loop, address](const auto& closed, const std::string& reason) {
           Forget(loop, closed, address, reason);
         }});
  } catch (const std::bad_alloc&) {
    return Forget(loop, nullptr, address, "out of memory");
  }
  loop.connections.insert(connection);
  ++meter_.open;
  {
    const storage::MutexLock lock(mutex_);
    auto& connections = by_address_[address];
    connections.erase(connections.find(nullptr));
    connections.insert(connection);
  }
  connection->Start();
  if (draining_) connection->BeginDrain();
}

void Listener::Forget(Loop& loop, const std::shared_ptr<ClientConnection>& connection,
                      const std::string& address, const std::string& reason) {
  meter_.open -= static_cast<int>(loop.connections.erase(connection));
  if (closing_ && loop.connections.empty()) loop.ticks.cancel();
  {
    const storage::MutexLock lock(mutex_);
    const auto found = by_address_.find(address);
    if (found == by_address_.end()) return;
    const auto entry = found->second.find(connection);
    if (entry != found->second.end()) {
      found->second.erase(entry);
      --count_;
    }
    if (found->second.empty()) by_address_.erase(found);
  }
  if (reason.empty()) return;
  ++meter_.ended;
  if (warnings_.Count(address + reason)) {
    spdlog::warn("connection closed: reason='{}' peer={}", reason, address);
  }
}

void Listener::Tick(Loop& loop) {
  loop.ticks.expires_after(kTick);
  loop.ticks.async_wait([this, &loop](const auto& error) {
    if (error || closing_) return;  // Close uses this timer for its grace time
    const auto now = ClientConnection::Clock::now();
    const auto connections = loop.connections;  // a copy: Tick may remove a connection
    for (const auto& connection : connections) connection->Tick(now);
    Tick(loop);
  });
}

void Listener::StopAccepting() {
  accept_retry_.cancel();
  acceptors_.clear();
}

void Listener::BeginDrain() {
  if (draining_.exchange(true)) return;
  std::latch drained(static_cast<std::ptrdiff_t>(loops_.size()));
  for (const auto& loop : loops_) {
    boost::asio::post(loop->context, [this, &loop = *loop, &drained] {
      if (&loop == loops_.front().get()) {
        // Closing an acceptor resets the connections that wait in its queue.
        for (Acceptor& acceptor : acceptors_) AcceptWaiting(acceptor);
        StopAccepting();
      }
      const auto connections = loop.connections;
      for (const auto& connection : connections) connection->BeginDrain();
      drained.count_down();
    });
  }
  drained.wait();
}

void Listener::Close(std::chrono::milliseconds grace) {
  if (closing_.exchange(true)) return;
  draining_ = true;
  if (!loops_.front()->thread.joinable()) return;  // Listen failed or was not called
  std::latch drained(static_cast<std::ptrdiff_t>(loops_.size()));
  for (const auto& loop : loops_) {
    boost::asio::post(loop->context, [this, &loop = *loop, &drained, grace] {
      if (&loop == loops_.front().get()) StopAccepting();
      // A drained connection closes after its last call.
      const auto draining = loop.connections;
      for (const auto& connection : draining) connection->Drain();
      drained.count_down();
      loop.work.reset();
      loop.ticks.expires_after(loop.connections.empty() ? std::chrono::milliseconds(0) : grace);
      loop.ticks.async_wait([&loop](const auto&) {
        const auto remaining = loop.connections;
        for (const auto& connection : remaining) connection->Close();
      });
    });
  }
  drained.wait();
}

}  // namespace motiondb::server
