#include "client/connection.h"

#include <fmt/format.h>
#include <motiondb/call_error.h>

#include <random>

#include "client/call_failure.h"

namespace motiondb::client {
namespace {

constexpr std::chrono::milliseconds kReasonTimeout{2000};

std::shared_ptr<grpc::Channel> OpenChannel(const ClientOptions& options) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(options.max_receive_bytes);
  arguments.SetMaxSendMessageSize(options.max_send_bytes);
  // A motiondb server is on one's own network: a proxy for the web is not the way to it.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // Try again soon, so that a server that is just starting is found within connect_timeout.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  if (options.tls && !options.tls->server_name.empty()) {
    arguments.SetSslTargetNameOverride(options.tls->server_name);
  }
  return grpc::CreateCustomChannel(options.server, options.credentials, arguments);
}

// Unlikely to be met twice.
std::string NewRequestId() {
  thread_local std::mt19937_64 random{std::random_device{}()};
  return fmt::format("{:016x}", random());
}

// A server that ends cancels what comes in its last moment.
absl::Status BrokenOff(const absl::Status& status, const OutgoingCall& call) {
  if (!absl::IsCancelled(status) || call.is_cancelled) return status;
  return absl::UnavailableError("the call was broken off");
}

double Seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

OutgoingCall::OutgoingCall(const CallOptions& its_options)
    : options(its_options), request_id(NewRequestId()) {}

Client::Connection::Connection(ClientOptions options)
    : options_(std::move(options)),
      channel_(OpenChannel(options_)),
      databases(v1::DatabaseService::NewStub(channel_)),
      clips(v1::ClipService::NewStub(channel_)),
      models(v1::ModelService::NewStub(channel_)),
      queries(v1::QueryService::NewStub(channel_)),
      observations(v1::ObserveService::NewStub(channel_)),
      operations(v1::OperationService::NewStub(channel_)),
      access(v1::AccessService::NewStub(channel_)),
      store(v1::StoreService::NewStub(channel_)),
      server(v1::ServerService::NewStub(channel_)) {}

absl::Status Client::Connection::WaitUntilConnected() const {
  if (channel_->WaitForConnected(std::chrono::system_clock::now() + options_.connect_timeout)) {
    return absl::OkStatus();
  }
  // An attempt that is still under way has nothing to say.
  if (channel_->GetState(/*try_to_connect=*/false) != GRPC_CHANNEL_TRANSIENT_FAILURE) {
    return ConnectError(options_, "");
  }
  // A channel tells only a call why it failed: at once, and no call leaves here.
  OutgoingCall call({.timeout = kReasonTimeout});
  Prepare(call);
  v1::GetDatabaseResponse unused;
  const grpc::Status status =
      databases->GetDatabase(&call.context, v1::GetDatabaseRequest(), &unused);
  if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED) return ConnectError(options_, "");
  // Else the server has come meanwhile and answered.
  return status.error_code() == grpc::StatusCode::UNAVAILABLE
             ? ConnectError(options_, status.error_message())
             : absl::OkStatus();
}

std::chrono::milliseconds Client::Connection::TimeoutOf(const CallOptions& options) const {
  return options.timeout.value_or(options_.call_timeout);
}

void Client::Connection::Prepare(OutgoingCall& call) const {
  call.context.AddMetadata("x-request-id", call.request_id);
  if (!options_.token.empty()) {
    call.context.AddMetadata("authorization", "Bearer " + options_.token);
  }
  const auto timeout = TimeoutOf(call.options);
  // Later than a year is as good as never, and cannot overflow the clock.
  if (timeout > std::chrono::hours(24 * 365)) return;
  call.context.set_deadline(std::chrono::system_clock::now() + timeout);
}

absl::Status Client::Connection::Finish(const grpc::Status& status,
                                        const OutgoingCall& call) const {
  absl::Status result = FromGrpc(status);
  if (result.ok()) return result;
  // What gRPC itself ends brings none; the server may have begun with it all the same.
  const bool by_server = !RequestId(result).empty();
  if (!by_server) result = WithRequestId(BrokenOff(result, call), call.request_id);
  if (result.code() == absl::StatusCode::kUnavailable) {
    return WithMessage(
        result, fmt::format("the motiondb server at {} is not available ({}){}", options_.server,
                            std::string(result.message()),
                            by_server ? ""
                                      : ": see that motiondbd runs there, or give the address of "
                                        "another"));
  }
  // gRPC's own words for a deadline that passed here; a server that ran out of time says more.
  if (result.code() == absl::StatusCode::kDeadlineExceeded &&
      status.error_message() == "Deadline Exceeded") {
    return WithMessage(
        result, fmt::format("no answer from the motiondb server at {} within {:g} s (request {})",
                            options_.server, Seconds(TimeoutOf(call.options)), call.request_id));
  }
  return result;
}

}  // namespace motiondb::client
