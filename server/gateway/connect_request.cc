#include "server/gateway/connect_request.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <string_view>
#include <utility>

#include "core/motion/error.h"
#include "server/gateway/connect_json.h"
#include "server/gateway/http_content.h"
#include "server/http2/grpc_wire.h"
#include "server/translate/status_mapping.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::string_view kPackage = "motiondb.v1";
constexpr std::size_t kMaxTimeoutDigits = 10;

HttpFields JsonFields() {
  return {{"content-type", "application/json"}, {"x-content-type-options", "nosniff"}};
}

HttpResponse UnaryError(const grpc::Status& error, unsigned http_status) {
  HttpResponse response{.status = http_status == 0 ? HttpStatusOf(error.error_code()) : http_status,
                        .fields = JsonFields(),
                        .body = ConnectErrorJson(error)};
  if (response.status == 401) response.fields.emplace_back("www-authenticate", "Bearer");
  return response;
}

template <typename... Args>
grpc::Status Fault(absl::StatusCode code, fmt::format_string<Args...> format, Args&&... args) {
  return ToGrpcStatus(absl::Status(code, fmt::format(format, std::forward<Args>(args)...)));
}

std::string PathOf(const google::protobuf::MethodDescriptor& method) {
  return fmt::format("/{}/{}", method.service()->full_name(), method.name());
}

// Returns the RPC of exactly this path; null if there is none in the package.
const google::protobuf::MethodDescriptor* FindMethod(const std::string& path) {
  const auto* const method = FindRpc(path);
  if (method == nullptr || method->file()->package() != kPackage) return nullptr;
  return PathOf(*method) == path ? method : nullptr;
}

struct Coding {
  std::string_view content;
  std::string_view accepted;
};

// Fills in the codings. Returns the error of an unsupported one.
grpc::Status ReadCodings(const HttpRequest& head, ConnectRequest& request) {
  const Coding names = request.streams
                           ? Coding{"connect-content-encoding", "connect-accept-encoding"}
                           : Coding{"content-encoding", "accept-encoding"};
  const std::string content = text::LowerCase(Trimmed(head.Find(names.content)));
  if (!content.empty() && content != "identity" && content != "gzip") {
    return Fault(absl::StatusCode::kUnimplemented, "{}: expected gzip or identity, got '{}'",
                 names.content, content);
  }
  request.sends_gzip = content == "gzip";
  const std::string_view accepted = head.Find(names.accepted);
  request.accepts_gzip = accepted.empty() ? request.sends_gzip : AcceptsGzip(accepted);
  return grpc::Status::OK;
}

grpc::Status ReadTimeout(std::string_view text, ConnectRequest& request) {
  if (text.empty()) return grpc::Status::OK;
  std::int64_t milliseconds = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), milliseconds);
  if (text.size() > kMaxTimeoutDigits || parsed.ec != std::errc() ||
      parsed.ptr != text.data() + text.size() || milliseconds < 0) {
    return Fault(absl::StatusCode::kInvalidArgument,
                 "connect-timeout-ms: expected a positive number of at most {} digits, got '{}'",
                 kMaxTimeoutDigits, text);
  }
  request.timeout = std::chrono::milliseconds(milliseconds);
  return grpc::Status::OK;
}

grpc::Status ReadFields(const HttpRequest& head, ConnectRequest& request) {
  if (request.method->client_streaming()) {
    return Fault(
        absl::StatusCode::kUnimplemented,
        "{} streams requests, which this port does not support: use gRPC at the address of "
        "--listen",
        request.method->full_name());
  }
  const std::string_view version = head.Find("connect-protocol-version");
  if (!version.empty() && version != "1") {
    return Fault(absl::StatusCode::kInvalidArgument,
                 "connect-protocol-version: expected 1, got '{}'", version);
  }
  if (grpc::Status codings = ReadCodings(head, request); !codings.ok()) return codings;
  return ReadTimeout(head.Find("connect-timeout-ms"), request);
}

// Fills in codec and framing. False: the method does not have this content type.
bool ReadContentType(std::string_view text, ConnectRequest& request) {
  const std::string type = text::LowerCase(Trimmed(text.substr(0, text.find(';'))));
  const bool is_stream = type == "application/connect+json" || type == "application/connect+proto";
  if (!is_stream && type != "application/json" && type != "application/proto") return false;
  request.is_json = type.ends_with("json");
  request.streams = is_stream;
  const bool has_streams = request.method->client_streaming() || request.method->server_streaming();
  // A unary request of a method that streams requests gets the error that names gRPC.
  return is_stream == has_streams || (!is_stream && request.method->client_streaming());
}

}  // namespace

std::string ConnectRequest::content_type() const {
  return fmt::format("application/{}{}", streams ? "connect+" : "", is_json ? "json" : "proto");
}

std::string ConnectRequest::path() const { return PathOf(*method); }

std::optional<ConnectRefusal> ParseConnectRequest(const HttpRequest& request,
                                                  ConnectRequest& parsed) {
  parsed.method = FindMethod(request.path);
  if (parsed.method == nullptr) {
    return ConnectRefusal{Fault(absl::StatusCode::kUnimplemented,
                                "unknown path; expected /{}.SERVICE/METHOD", kPackage),
                          404};
  }
  parsed.request_id = PrintableAscii(request.Find("x-request-id"));
  if (request.method != "POST") {
    return ConnectRefusal{
        Fault(absl::StatusCode::kUnimplemented, "expected POST, got {}", request.method),
        405,
        {{"allow", "POST"}}};
  }
  if (!ReadContentType(request.Find("content-type"), parsed)) {
    const bool streams = parsed.method->server_streaming();
    const std::string expected = streams ? "application/connect+json, application/connect+proto"
                                         : "application/json, application/proto";
    parsed.streams = false;  // the error is unary: the client did not ask for envelopes
    return ConnectRefusal{
        Fault(absl::StatusCode::kInvalidArgument, "content-type: expected one of {}", expected),
        415,
        {{"accept-post", expected}}};
  }
  if (grpc::Status fault = ReadFields(request, parsed); !fault.ok()) {
    const char* const name = parsed.streams ? "connect-accept-encoding" : "accept-encoding";
    return ConnectRefusal{std::move(fault), 0, {{name, "gzip"}}};
  }
  parsed.authorization = PrintableAscii(request.Find("authorization"));
  return std::nullopt;
}

HttpResponse ErrorResponse(const ConnectRequest& request, const grpc::Status& error,
                           unsigned http_status) {
  if (!request.streams) return UnaryError(error, http_status);
  HttpResponse response = StreamHead(request);
  response.body = MakeEnvelope(kEndOfStream, EndOfStreamJson(error));
  return response;
}

HttpResponse StreamHead(const ConnectRequest& request) {
  HttpResponse head{
      .fields = {{"content-type", request.content_type()}, {"x-content-type-options", "nosniff"}}};
  if (request.accepts_gzip) head.fields.emplace_back("connect-content-encoding", "gzip");
  return head;
}

}  // namespace motiondb::server
