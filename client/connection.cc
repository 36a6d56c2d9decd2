#include "client/connection.h"

#include <fmt/format.h>
#include <motiondb/call_error.h>

#include <algorithm>
#include <iterator>
#include <random>
#include <thread>

#include "absl/strings/str_split.h"
#include "client/call_failure.h"

namespace motiondb::client {
namespace {

constexpr std::chrono::milliseconds kReasonTimeout{2000};
constexpr std::chrono::milliseconds kRoundPause{20};

// Before the second attempt at the only address. It may be a proxy, and a server that is killed
// closes its sockets one after another: meanwhile the proxy can send it a call again.
constexpr std::chrono::milliseconds kPauseOfOnlyAddress{100};
constexpr int kAttemptsAtOnlyAddress = 2;
// If no server has begun the call, because the one behind the proxy stops: for 2 s.
constexpr int kAttemptsWhileStopping = 20;

// Of a client with several addresses: when a machine that cannot be reached is given up, and one
// that does not respond any more.
constexpr int kConnectAttempt_ms = 2'000;
constexpr int kPingAfterIdle_ms = 10'000;
constexpr int kPingReply_ms = 10'000;

std::shared_ptr<grpc::Channel> OpenChannel(const ClientOptions& options, bool has_others) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(options.max_receive_bytes);
  arguments.SetMaxSendMessageSize(options.max_send_bytes);
  // Servers are in the local network: ignore the http_proxy variable.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // Retry fast, so that a starting server is reached within connect_timeout.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  if (has_others) {
    // In gRPC this is also the time limit of one attempt to connect, by default 20 s.
    arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, kConnectAttempt_ms);
    // Only during calls. motiondbd permits it.
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kPingAfterIdle_ms);
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kPingReply_ms);
    arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  }
  if (options.tls && !options.tls->server_name.empty()) {
    arguments.SetSslTargetNameOverride(options.tls->server_name);
  }
  return grpc::CreateCustomChannel(options.server, options.credentials, arguments);
}

ClientOptions WithServer(ClientOptions options, std::string address) {
  options.server = std::move(address);
  return options;
}

// Returns 64 random bits in hexadecimal.
std::string NewRequestId() {
  thread_local std::mt19937_64 random{std::random_device{}()};
  return fmt::format("{:016x}", random());
}

// A call that ended without a status of the server is UNAVAILABLE: a server that stops cancels the
// last calls, and a proxy resets the calls of a server that has died (INTERNAL_ERROR of HTTP/2).
absl::Status EndedByPeer(const absl::Status& status, const OutgoingCall& call) {
  if (absl::IsCancelled(status) && !call.is_cancelled) {
    return absl::UnavailableError("the call was cancelled");
  }
  if (absl::IsInternal(status) && status.message() == "Received RST_STREAM with error code 2") {
    return absl::UnavailableError("the call was reset");
  }
  return status;
}

bool IsStopping(const absl::Status& status) { return ErrorReason(status) == "SERVER_STOPPING"; }

// Returns whether no server has begun the call: it has no socket as its peer, since its channel was
// not connected, or the server refused it because it stops. A channel to a socket of this machine
// or to numbers is named like its peer; its calls count as begun.
bool IsUnbegun(const absl::Status& status, const OutgoingCall& call) {
  if (IsStopping(status)) return true;
  const std::string peer = call.context.peer();
  return !peer.starts_with("ipv4:") && !peer.starts_with("ipv6:") && !peer.starts_with("unix");
}

double Seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

absl::StatusOr<std::vector<std::string>> AddressesOf(const std::string& server) {
  std::vector<std::string> addresses = absl::StrSplit(server, ',');
  for (const std::string& address : addresses) {
    if (!address.empty()) continue;
    return absl::InvalidArgumentError(fmt::format(
        "ClientOptions::server: expected HOST:PORT or HOST:PORT,HOST:PORT,..., got '{}'", server));
  }
  return addresses;
}

Endpoint::Endpoint(const ClientOptions& options, bool has_others)
    : address(options.server),
      channel(OpenChannel(options, has_others)),
      databases(v1::DatabaseService::NewStub(channel)),
      marker_sets(v1::MarkerSetService::NewStub(channel)),
      clips(v1::ClipService::NewStub(channel)),
      segments(v1::SegmentService::NewStub(channel)),
      edits(v1::EditService::NewStub(channel)),
      models(v1::ModelService::NewStub(channel)),
      views(v1::ViewService::NewStub(channel)),
      queries(v1::QueryService::NewStub(channel)),
      observations(v1::ObserveService::NewStub(channel)),
      operations(v1::OperationService::NewStub(channel)),
      access(v1::AccessService::NewStub(channel)),
      store(v1::StoreService::NewStub(channel)),
      server(v1::ServerService::NewStub(channel)) {}

Client::Connection::Connection(const ClientOptions& options,
                               const std::vector<std::string>& addresses)
    : options_(options) {
  for (const std::string& address : addresses) {
    endpoints_.push_back(
        std::make_unique<const Endpoint>(WithServer(options, address), addresses.size() > 1));
  }
}

absl::Status Client::Connection::WaitUntilConnected() const {
  if (endpoints_.size() > 1) return WaitForAny();
  const Endpoint& only = current();
  if (only.channel->WaitForConnected(std::chrono::system_clock::now() + options_.connect_timeout)) {
    return absl::OkStatus();
  }
  return ConnectErrorOf(only);
}

absl::Status Client::Connection::WaitForAny() const {
  using Clock = std::chrono::system_clock;
  const auto end = Clock::now() + options_.connect_timeout;
  // In rounds, so that starting servers are reached. An address that does not respond gets its
  // share of the time.
  const auto share = options_.connect_timeout / address_count();
  do {
    for (std::size_t i = 0; i < endpoints_.size(); ++i) {
      grpc::Channel& channel = *endpoints_[i]->channel;
      const auto latest = std::min(end, Clock::now() + share);
      auto state = channel.GetState(/*try_to_connect=*/true);
      while (state != GRPC_CHANNEL_READY && state != GRPC_CHANNEL_TRANSIENT_FAILURE &&
             channel.WaitForStateChange(state, latest)) {
        state = channel.GetState(/*try_to_connect=*/true);
      }
      if (state != GRPC_CHANNEL_READY) continue;
      current_ = i;
      return absl::OkStatus();
    }
    std::this_thread::sleep_for(kRoundPause);
  } while (Clock::now() < end);
  std::string reasons;
  absl::Status last;
  for (const auto& endpoint : endpoints_) {
    last = ConnectErrorOf(*endpoint);
    if (last.ok()) return last;  // it has started meanwhile; the calls will find it
    fmt::format_to(std::back_inserter(reasons), "{}{}", reasons.empty() ? "" : "; ",
                   std::string(last.message()));
  }
  return WithMessage(last, reasons);
}

absl::Status Client::Connection::ConnectErrorOf(const Endpoint& endpoint) const {
  const ClientOptions options = WithServer(options_, endpoint.address);
  // An attempt in progress has no error yet.
  if (endpoint.channel->GetState(/*try_to_connect=*/false) != GRPC_CHANNEL_TRANSIENT_FAILURE) {
    return ConnectError(options, "");
  }
  // Only a failed call contains the reason. It fails immediately, without network traffic.
  OutgoingCall call(endpoint);
  call.options.timeout = kReasonTimeout;
  Prepare(call);
  v1::GetDatabaseResponse unused;
  const grpc::Status status =
      endpoint.databases->GetDatabase(&call.context, v1::GetDatabaseRequest(), &unused);
  if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED) return ConnectError(options, "");
  // Any other code: the server has started meanwhile and responded.
  return status.error_code() == grpc::StatusCode::UNAVAILABLE
             ? ConnectError(options, status.error_message())
             : absl::OkStatus();
}

std::unique_ptr<OutgoingCall> Client::Connection::Begin(const CallOptions& options,
                                                        const std::string& database) const {
  auto call = std::make_unique<OutgoingCall>(current());
  call->options = options;
  if (!call->options.timeout) call->options.timeout = options_.call_timeout;
  call->database = database;
  call->request_id = NewRequestId();
  call->tried = call->endpoint.address;
  // More than a year counts as unlimited, which avoids an overflow of the clock.
  if (*call->options.timeout <= std::chrono::hours(24 * 365)) {
    call->deadline = std::chrono::system_clock::now() + *call->options.timeout;
  }
  Prepare(*call);
  return call;
}

std::unique_ptr<OutgoingCall> Client::Connection::NextAttempt(Effect effect,
                                                              const absl::Status& status,
                                                              const OutgoingCall& call) const {
  if (!absl::IsUnavailable(status) || !call.is_repeatable) return nullptr;
  if (effect == Effect::kChange && !IsUnbegun(status, call)) return nullptr;
  // A retry delay is about the server, and the only one needs it.
  const bool is_only = endpoints_.size() == 1;
  if (is_only && RetryDelay(status)) return nullptr;
  const int max_attempts = !is_only             ? address_count()
                           : IsStopping(status) ? kAttemptsWhileStopping
                                                : kAttemptsAtOnlyAddress;
  if (call.attempt >= max_attempts) return nullptr;
  if (is_only) std::this_thread::sleep_for(kPauseOfOnlyAddress);
  auto next = std::make_unique<OutgoingCall>(current());
  next->options = call.options;
  next->database = call.database;
  next->request_id = call.request_id;
  next->deadline = call.deadline;
  next->tried = call.tried;
  if (!is_only) next->tried += ", " + next->endpoint.address;
  next->attempt = call.attempt + 1;
  Prepare(*next);
  return next;
}

void Client::Connection::Leave(const Endpoint& endpoint) const {
  for (std::size_t i = 0; i < endpoints_.size(); ++i) {
    if (endpoints_[i].get() != &endpoint) continue;
    current_.compare_exchange_strong(i, (i + 1) % endpoints_.size());
    return;
  }
}

void Client::Connection::Prepare(OutgoingCall& call) const {
  call.context.AddMetadata("x-request-id", call.request_id);
  if (!call.database.empty()) call.context.AddMetadata(kDatabaseKey, call.database);
  if (!options_.token.empty()) {
    call.context.AddMetadata("authorization", "Bearer " + options_.token);
  }
  if (call.deadline != std::chrono::system_clock::time_point::max()) {
    call.context.set_deadline(call.deadline);
  }
}

absl::Status Client::Connection::Finish(const grpc::Status& status,
                                        const OutgoingCall& call) const {
  absl::Status result = FromGrpc(status);
  if (result.ok()) return result;
  // Errors of gRPC itself have no request id, although the server may have processed the call.
  const bool by_server = !RequestId(result).empty();
  if (!by_server) result = WithRequestId(EndedByPeer(result, call), call.request_id);
  if (result.code() == absl::StatusCode::kUnavailable) {
    Leave(call.endpoint);
    const bool is_one = call.tried == call.endpoint.address;
    return WithMessage(
        result,
        fmt::format("the motiondb server{} at {} {} not available ({}){}", is_one ? "" : "s",
                    call.tried, is_one ? "is" : "are", std::string(result.message()),
                    by_server || endpoints_.size() > 1
                        ? ""
                        : "; check that motiondbd runs there, or use another address"));
  }
  // This is gRPC's message for a deadline that expired here. A server's message has more details.
  if (result.code() == absl::StatusCode::kDeadlineExceeded &&
      status.error_message() == "Deadline Exceeded") {
    return WithMessage(
        result,
        fmt::format("no answer from the motiondb server at {} within {:g} s (request {})",
                    call.endpoint.address, Seconds(*call.options.timeout), call.request_id));
  }
  return result;
}

}  // namespace motiondb::client
