#include "server/gateway/login_session.h"

#include <fmt/format.h>

#include <boost/asio/post.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "absl/strings/ascii.h"
#include "core/motion/error.h"
#include "server/engine/work/clock.h"
#include "server/engine/work/thread_pool.h"
#include "server/gateway/connect_json.h"
#include "server/gateway/http_content.h"
#include "server/gateway/page_cookie.h"
#include "server/gateway/page_files.h"
#include "server/http2/grpc_wire.h"
#include "server/rpc/call.h"
#include "server/rpc/call_context.h"
#include "server/rpc/call_identity.h"
#include "server/translate/resource_name.h"
#include "server/translate/status_mapping.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

using nlohmann::json;

constexpr std::string_view kLogin = "/login";
constexpr std::string_view kLogout = "/logout";
constexpr std::string_view kSession = "/session";
constexpr std::int64_t kMaxBodyBytes = 4 << 10;
constexpr std::string_view kBearer = "Bearer ";

HttpResponse SessionAnswer(unsigned status, std::string body) {
  HttpResponse response{
      .status = status,
      .fields = {{"content-type", "application/json"}, {"cache-control", "no-store"}},
      .body = std::move(body)};
  AddPageSecurity(response.fields);
  return response;
}

HttpResponse SessionFailure(const absl::Status& fault) {
  const grpc::Status error = ToGrpcStatus(fault);
  return SessionAnswer(HttpStatusOf(error.error_code()), ConnectErrorJson(error));
}

HttpResponse WrongMethod(const char* expected) {
  const absl::Status fault = absl::UnimplementedError(fmt::format("expected {}", expected));
  HttpResponse response = SessionAnswer(405, ConnectErrorJson(ToGrpcStatus(fault)));
  response.fields.emplace_back("allow", expected);
  return response;
}

// `caller`: null if no valid token came. `reason`: why.
HttpResponse DescribeSession(bool required, const Caller* caller, std::string_view reason) {
  json answer = {{"authenticationRequired", required}, {"authenticated", caller != nullptr}};
  if (caller != nullptr) {
    answer["principal"] = text::SafeText(caller->principal);
    answer["role"] = RoleName(caller->role);
    answer["database"] = caller->database.empty() ? "" : DatabaseName(caller->database);
  } else if (!reason.empty()) {
    answer["reason"] = reason;
  }
  return SessionAnswer(200, answer.dump(-1, ' ', false, json::error_handler_t::replace));
}

// Returns the token of a login.
absl::StatusOr<std::string> ParseLogin(const std::string& body) {
  const json request = json::parse(body, nullptr, false);
  if (!request.is_object() || !request.contains("token") || !request["token"].is_string()) {
    return core::InvalidArgument("expected JSON {{\"token\": \"...\"}}");
  }
  std::string token = request["token"].get<std::string>();
  absl::StripAsciiWhitespace(&token);
  if (token.empty()) return core::InvalidArgument("token: expected the token, got no text");
  return PrintableAscii(token);
}

// Reads or creates a session, on a thread that may read the store.
class SessionWork final : public HttpWork, public std::enable_shared_from_this<SessionWork> {
 public:
  SessionWork(const SessionContext& context, const HttpRequest& request,
              std::shared_ptr<HttpExchange> exchange)
      : context_(context),
        exchange_(std::move(exchange)),
        is_login_(request.path == kLogin),
        https_(UsesHttps(request, context.has_tls)),
        request_id_(PrintableAscii(request.Find("x-request-id")).substr(0, 128)),
        authorization_(PrintableAscii(request.Find("authorization"))) {
    if (is_login_ || !authorization_.empty()) return;
    const std::string token = TokenInCookie(request, context.has_tls);
    has_cookie_ = !token.empty();
    if (has_cookie_) authorization_ = fmt::format("{}{}", kBearer, token);
  }

  std::optional<HttpResponse> Admit(std::int64_t body_bytes) override {
    if (body_bytes <= kMaxBodyBytes) return std::nullopt;
    HttpResponse response = SessionFailure(core::InvalidArgument(
        "expected a body of at most {} bytes, got {} or more", kMaxBodyBytes, body_bytes));
    response.status = 413;
    return response;
  }

  void Start(std::string body) override {
    boost::asio::post(
        context_.thread.executor(), [self = shared_from_this(), body = std::move(body)] {
          std::optional<HttpResponse> response;
          const grpc::Status done =
              RunHandler([] { return false; },
                         [&] {
                           response = self->is_login_ ? self->Login(body) : self->Describe();
                           return absl::OkStatus();
                         });
          self->exchange_->Post([self, response = std::move(response), done] {
            if (self->cancelled_) return;
            self->exchange_->Respond(response.has_value() ? *response : Failure(done));
          });
        });
  }

  void OnSent() override {}
  void Cancel() override { cancelled_ = true; }

 private:
  static HttpResponse Failure(const grpc::Status& error) {
    return SessionAnswer(HttpStatusOf(error.error_code()), ConnectErrorJson(error));
  }

  absl::StatusOr<Caller> Authenticate(const std::string& authorization) {
    auto caller = context_.host.access.Authenticate(
        {authorization, exchange_->common_name(), AddressOf(exchange_->peer())});
    if (absl::IsResourceExhausted(caller.status())) {
      context_.host.monitor.calls().CountRefusedAttempt();
    }
    return caller;
  }

  HttpResponse Login(const std::string& body) {
    const auto token = ParseLogin(body);
    if (!token.ok()) return SessionFailure(token.status());
    const auto caller = Authenticate(fmt::format("{}{}", kBearer, *token));
    Audit(caller);
    if (!caller.ok()) return SessionFailure(caller.status());
    const bool required = context_.host.access.authentication();
    HttpResponse response = DescribeSession(required, &*caller, "");
    if (required) response.fields.emplace_back("set-cookie", SetTokenCookie(*token, https_));
    return response;
  }

  void Audit(const absl::StatusOr<Caller>& caller) {
    storage::AuditRecord record;
    record.time_us = NowMicroseconds();
    record.principal = text::SafeText(caller.ok() ? caller->principal : kAnonymous);
    record.peer = AddressOf(exchange_->peer());
    record.method = "Login";
    record.code = static_cast<std::int32_t>(caller.status().code());
    record.request_id = text::RedactSecrets(request_id_);
    // As an entry of a call that changes nothing: their number is limited.
    const absl::Status stored = context_.host.access.Record(record, false, false);
    static_cast<void>(stored);  // it is logged
  }

  HttpResponse Describe() {
    const bool required = context_.host.access.authentication();
    if (required && authorization_.empty() && exchange_->common_name().empty()) {
      return DescribeSession(required, nullptr, "");
    }
    const auto caller = Authenticate(authorization_);
    if (caller.ok()) return DescribeSession(required, &*caller, "");
    if (!absl::IsUnauthenticated(caller.status())) return SessionFailure(caller.status());
    HttpResponse response =
        DescribeSession(required, nullptr, std::string(caller.status().message()));
    if (has_cookie_) DeleteTokenCookie(response.fields);
    return response;
  }

  const SessionContext& context_;
  const std::shared_ptr<HttpExchange> exchange_;
  const bool is_login_;
  const bool https_;
  const std::string request_id_;
  std::string authorization_;
  bool has_cookie_ = false;
  bool cancelled_ = false;
};

}  // namespace

bool IsSessionRequest(const HttpRequest& request) {
  return request.path == kLogin || request.path == kLogout || request.path == kSession;
}

std::variant<HttpResponse, std::shared_ptr<HttpWork>> AnswerSessionRequest(
    const SessionContext& context, const HttpRequest& request,
    const std::shared_ptr<HttpExchange>& exchange) {
  const bool reads = request.path == kSession;
  if (reads && request.method != "GET") return WrongMethod("GET");
  if (!reads && request.method != "POST") return WrongMethod("POST");
  // A navigation to /session has "none".
  const bool is_navigation = reads && request.Find("sec-fetch-site") == "none";
  if (!is_navigation) {
    const absl::Status same = CheckSameOrigin(request, context.has_tls);
    if (!same.ok()) return SessionFailure(same);
  }
  if (request.path == kLogout) {
    HttpResponse response = SessionAnswer(200, "{}");
    DeleteTokenCookie(response.fields);
    return response;
  }
  // A form of another site cannot have this type.
  const std::string_view type = request.Find("content-type");
  if (!reads && text::LowerCase(Trimmed(type.substr(0, type.find(';')))) != "application/json") {
    HttpResponse response =
        SessionFailure(core::InvalidArgument("content-type: expected application/json"));
    response.status = 415;
    return response;
  }
  return std::make_shared<SessionWork>(context, request, exchange);
}

}  // namespace motiondb::server
