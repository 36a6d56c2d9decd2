#include "server/gateway/gateway.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <utility>
#include <variant>

#include "core/motion/error.h"
#include "server/engine/work/thread_pool.h"
#include "server/gateway/connect_request.h"
#include "server/gateway/gateway_call.h"
#include "server/gateway/login_session.h"
#include "server/gateway/openapi.h"
#include "server/gateway/page_cookie.h"
#include "server/gateway/page_files.h"
#include "server/http1/http1_connection.h"
#include "server/listen/listener.h"
#include "server/rpc/call_context.h"
#include "server/security/security_options.h"
#include "server/translate/status_mapping.h"

namespace motiondb::server {
namespace {

constexpr int kConverterThreads = 2;
constexpr char kOpenApiPath[] = "/openapi.json";

// Returns whether the Host header has an address, or a name that cannot be registered on the
// internet: one without a dot, or of a local network or cluster.
bool IsLocalName(std::string_view host) {
  if (host.starts_with('[')) return true;  // an IPv6 address
  host = host.substr(0, host.rfind(':'));
  if (host.find_first_not_of("0123456789.") == std::string_view::npos) return true;
  constexpr std::array<std::string_view, 4> kLocal = {".local", ".internal", ".home.arpa",
                                                      ".localhost"};
  return host.find('.') == std::string_view::npos ||
         std::ranges::any_of(kLocal, [&](std::string_view end) { return host.ends_with(end); });
}

Http1Limits LimitsOf(const CallLimitOptions& options) {
  Http1Limits limits;
  limits.head_bytes = 2 * static_cast<std::uint32_t>(options.max_metadata_bytes);
  limits.body_time = std::min(options.idle_limit, options.first_idle_limit);
  limits.answer_time = options.idle_limit;
  limits.idle_time = std::min(options.idle_limit, limits.idle_time);
  limits.bytes_per_millisecond = kMinBytesPerMillisecond;
  return limits;
}

}  // namespace

class ConnectHandler final : public HttpHandler {
 public:
  // `is_open`: calls need no token.
  ConnectHandler(std::shared_ptr<CallBridge> bridge, ThreadPool& converters, SessionContext session,
                 PageFiles page, bool is_open)
      : bridge_(std::move(bridge)),
        converters_(converters),
        session_(session),
        page_(std::move(page)),
        is_open_(is_open) {}

  std::variant<HttpResponse, std::shared_ptr<HttpWork>> Accept(
      const HttpRequest& request, const std::shared_ptr<HttpExchange>& exchange) override {
    if (request.path == kOpenApiPath) return OpenApi(request);
    if (IsSessionRequest(request)) return AnswerSessionRequest(session_, request, exchange);
    if (IsPageRequest(request)) return AnswerPageRequest(page_, request, exchange);
    ConnectRequest connect;
    if (auto refusal = ParseConnectRequest(request, connect)) {
      return Refuse(connect, *std::move(refusal), exchange->peer());
    }
    // A page of another site whose name resolves to this machine (DNS rebinding) could use the
    // rights of everyone here. A browser sends the name in Host.
    if (is_open_ && !IsLocalName(request.Find("host"))) {
      const absl::Status fault = absl::PermissionDeniedError(
          "without authentication, expected an address or a local name in Host; set "
          "--authentication token");
      return Refuse(connect, {ToGrpcStatus(fault)}, exchange->peer());
    }
    if (session_.host.access.authentication()) {
      const absl::Status allowed = AuthorizeByCookie(request, session_.has_tls, connect);
      if (!allowed.ok()) return Refuse(connect, {ToGrpcStatus(allowed)}, exchange->peer());
    }
    return std::make_shared<GatewayCall>(*bridge_, converters_, std::move(connect), exchange);
  }

  const CallLimitOptions& options() const { return bridge_->limits.options(); }

 private:
  HttpResponse Refuse(const ConnectRequest& request, ConnectRefusal refusal,
                      const std::string& peer) const {
    const grpc::Status error =
        request.method == nullptr
            ? refusal.error
            : bridge_->Refuse(request.path(), refusal.error, request.request_id, peer);
    HttpResponse response = ErrorResponse(request, error, refusal.http_status);
    std::ranges::move(refusal.fields, std::back_inserter(response.fields));
    return response;
  }

  static HttpResponse OpenApi(const HttpRequest& request) {
    if (request.method == "GET" || request.method == "HEAD") {
      return {.fields = {{"content-type", "application/json"}}, .body = std::string(kOpenApiJson)};
    }
    return {.status = 405,
            .fields = {{"content-type", "text/plain; charset=utf-8"}, {"allow", "GET, HEAD"}},
            .body = "expected GET\n"};
  }

  const std::shared_ptr<CallBridge> bridge_;
  ThreadPool& converters_;
  const SessionContext session_;
  const PageFiles page_;
  const bool is_open_;
};

namespace {

// Returns the page; without files if it is not installed.
absl::StatusOr<PageFiles> ReadPage(const std::string& web_root) {
  auto page = PageFiles::Read(web_root.empty() ? InstalledPageFolder() : web_root);
  if (absl::IsNotFound(page.status())) {
    spdlog::info("web page not installed, HTTP API only: {}", std::string(page.status().message()));
    return PageFiles();
  }
  if (!page.ok())
    return core::InvalidArgument("the web page: {}", std::string(page.status().message()));
  return page;
}

}  // namespace

Gateway::Gateway()
    : converters_(std::make_unique<ThreadPool>(kConverterThreads)),
      sessions_(std::make_unique<ThreadPool>(1)) {}

Gateway::~Gateway() = default;

absl::StatusOr<std::unique_ptr<Gateway>> Gateway::Start(const GatewayOptions& options,
                                                        ServiceContext& host,
                                                        std::shared_ptr<CallBridge> bridge) {
  MOTIONDB_ASSIGN_OR_RETURN(PageFiles page, ReadPage(options.web_root));
  const std::string& listen = options.listen;
  std::unique_ptr<Gateway> gateway(new Gateway());
  gateway->handler_ = std::make_unique<ConnectHandler>(
      std::move(bridge), *gateway->converters_,
      SessionContext{host, *gateway->sessions_, options.tls != nullptr}, std::move(page),
      !host.access.authentication());
  const auto make = [&handler = *gateway->handler_,
                     limits = LimitsOf(gateway->handler_->options())](AcceptedClient client) {
    return std::make_shared<Http1Connection>(handler, limits, std::move(client));
  };
  auto listener = Listener::Start(listen, {.tls = options.tls, .protocol = TlsProtocol::kHttp1},
                                  make, host.monitor.connections());
  if (!listener.ok()) {
    return absl::Status(listener.status().code(),
                        fmt::format("web-listen: {}", std::string(listener.status().message())));
  }
  gateway->listener_ = *std::move(listener);
  gateway->address_ =
      fmt::format("{}:{}", listen.substr(0, listen.rfind(':')), gateway->listener_->port());
  return gateway;
}

void Gateway::BeginDrain() { listener_->BeginDrain(); }

void Gateway::Close(std::chrono::milliseconds grace) { listener_->Close(grace); }

}  // namespace motiondb::server
