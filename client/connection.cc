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
  // Servers are in the local network: ignore the http_proxy variable.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // Retry fast, so that a starting server is reached within connect_timeout.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  if (options.tls && !options.tls->server_name.empty()) {
    arguments.SetSslTargetNameOverride(options.tls->server_name);
  }
  return grpc::CreateCustomChannel(options.server, options.credentials, arguments);
}

// Returns 64 random bits in hexadecimal.
std::string NewRequestId() {
  thread_local std::mt19937_64 random{std::random_device{}()};
  return fmt::format("{:016x}", random());
}

// A server that stops cancels the last calls. For the client this is UNAVAILABLE.
absl::Status RemoteCancelled(const absl::Status& status, const OutgoingCall& call) {
  if (!absl::IsCancelled(status) || call.is_cancelled) return status;
  return absl::UnavailableError("the call was cancelled");
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
      marker_sets(v1::MarkerSetService::NewStub(channel_)),
      clips(v1::ClipService::NewStub(channel_)),
      segments(v1::SegmentService::NewStub(channel_)),
      edits(v1::EditService::NewStub(channel_)),
      models(v1::ModelService::NewStub(channel_)),
      views(v1::ViewService::NewStub(channel_)),
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
  // An attempt in progress has no error yet.
  if (channel_->GetState(/*try_to_connect=*/false) != GRPC_CHANNEL_TRANSIENT_FAILURE) {
    return ConnectError(options_, "");
  }
  // Only a failed call contains the reason. It fails immediately, without network traffic.
  OutgoingCall call({.timeout = kReasonTimeout});
  Prepare(call);
  v1::GetDatabaseResponse unused;
  const grpc::Status status =
      databases->GetDatabase(&call.context, v1::GetDatabaseRequest(), &unused);
  if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED) return ConnectError(options_, "");
  // Any other code: the server has started meanwhile and responded.
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
  // More than a year counts as unlimited, which avoids an overflow of the clock.
  if (timeout > std::chrono::hours(24 * 365)) return;
  call.context.set_deadline(std::chrono::system_clock::now() + timeout);
}

absl::Status Client::Connection::Finish(const grpc::Status& status,
                                        const OutgoingCall& call) const {
  absl::Status result = FromGrpc(status);
  if (result.ok()) return result;
  // Errors of gRPC itself have no request id, although the server may have processed the call.
  const bool by_server = !RequestId(result).empty();
  if (!by_server) result = WithRequestId(RemoteCancelled(result, call), call.request_id);
  if (result.code() == absl::StatusCode::kUnavailable) {
    return WithMessage(
        result, fmt::format("the motiondb server at {} is not available ({}){}", options_.server,
                            std::string(result.message()),
                            by_server ? ""
                                      : "; check that motiondbd runs there, or use another "
                                        "address"));
  }
  // This is gRPC's message for a deadline that expired here. A server's message has more details.
  if (result.code() == absl::StatusCode::kDeadlineExceeded &&
      status.error_message() == "Deadline Exceeded") {
    return WithMessage(
        result, fmt::format("no answer from the motiondb server at {} within {:g} s (request {})",
                            options_.server, Seconds(TimeoutOf(call.options)), call.request_id));
  }
  return result;
}

}  // namespace motiondb::client
