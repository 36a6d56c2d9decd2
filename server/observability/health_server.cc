#include "server/observability/health_server.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <exception>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "core/motion/error.h"
#include "server/engine/work/memory_reserve.h"
#include "server/engine/work/thread_pool.h"
#include "server/http1/http1_connection.h"
#include "server/listen/listener.h"
#include "server/security/security_options.h"

namespace motiondb::server {
namespace {

// In bytes: request line with headers, and body. No page uses a body.
constexpr std::uint32_t kPageHeadBytes = 8192;
constexpr std::int64_t kPageBodyBytes = 1024;

HttpResponse ResponseOf(HttpAnswer answer) {
  return {
      .status = answer.status,
      .fields = {{"content-type", std::move(answer.content_type)}, {"cache-control", "no-store"}},
      .body = std::move(answer.body)};
}

HttpResponse PageRefusal(unsigned status, std::string reason) {
  return ResponseOf({.status = status, .body = std::move(reason) + "\n"});
}

Http1Limits ConnectionLimits(const HttpLimits& limits) {
  return {.head_bytes = kPageHeadBytes,
          .head_time = limits.request_time,
          .idle_time = limits.request_time,
          .body_time = limits.request_time,
          .answer_time = limits.answer_time,
          .bytes_per_millisecond = std::int64_t{1} << 40};  // no more time for larger pages
}

std::string ClientAddress(const HttpExchange& exchange) {
  return exchange.peer().substr(0, exchange.peer().rfind(':'));
}

// Makes pages for the connections, which are all on one thread.
class PageHandler final : public HttpHandler {
 public:
  using Take = std::function<void(const HttpAnswer&)>;

  PageHandler(HttpPages pages, int connections)
      : pages_(std::move(pages)), connections_(connections) {}

  std::variant<HttpResponse, std::shared_ptr<HttpWork>> Accept(
      const HttpRequest& request, const std::shared_ptr<HttpExchange>& exchange) override;
  // Makes the page on another thread, then calls `take` on this one. False if too many requests
  // wait for pages already, in total or from this address.
  bool MakeInBackground(const HttpPage& page, const std::shared_ptr<HttpExchange>& exchange,
                        Take take);
  // Waits for the pages that are being made. The listener must be closed.
  void Close() { page_thread_.Join(); }

 private:
  struct Taker {
    std::string address;
    Take take;
  };
  void Deliver(const HttpPage& page, const HttpAnswer& answer);

  const HttpPages pages_;
  const int connections_;
  std::map<const HttpPage*, std::vector<Taker>> takers_;  // by page that is being made
  int waiting_ = 0;                                       // in total
  std::map<std::string, int> waiting_by_address_;
  ThreadPool page_thread_{1};
};

// A request for a page that is made in the background.
class PageWork final : public HttpWork, public std::enable_shared_from_this<PageWork> {
 public:
  PageWork(PageHandler& handler, const HttpPage& page, std::shared_ptr<HttpExchange> exchange)
      : handler_(handler), page_(page), exchange_(std::move(exchange)) {}

  std::optional<HttpResponse> Admit(std::int64_t body_bytes) override {
    if (body_bytes <= kPageBodyBytes) return std::nullopt;
    return PageRefusal(413, "expected a request without a body");
  }
  void Start(std::string /*body*/) override {
    const bool is_coming = handler_.MakeInBackground(
        page_, exchange_, [self = shared_from_this()](const HttpAnswer& answer) {
          // Posted, so that each connection sends its output.
          self->exchange_->Post([self, answer] {
            if (!self->cancelled_) self->exchange_->Respond(ResponseOf(answer));
          });
        });
    if (is_coming) return;
    exchange_->Respond(PageRefusal(503, "too many requests wait for pages; retry later"));
  }
  void OnSent() override {}
  void Cancel() override { cancelled_ = true; }

 private:
  PageHandler& handler_;
  const HttpPage& page_;
  const std::shared_ptr<HttpExchange> exchange_;
  bool cancelled_ = false;
};

std::variant<HttpResponse, std::shared_ptr<HttpWork>> PageHandler::Accept(
    const HttpRequest& request, const std::shared_ptr<HttpExchange>& exchange) {
  const auto found = pages_.find(request.path);
  if (found == pages_.end()) return PageRefusal(404, "unknown page; see / for a list");
  if (request.method != "GET" && request.method != "HEAD") {
    HttpResponse refusal = PageRefusal(405, "expected GET or HEAD");
    refusal.fields.emplace_back("allow", "GET, HEAD");
    return refusal;
  }
  const HttpPage& page = found->second;
  if (page.is_immediate) return ResponseOf(page.make());
  return std::make_shared<PageWork>(*this, page, exchange);
}

bool PageHandler::MakeInBackground(const HttpPage& page,
                                   const std::shared_ptr<HttpExchange>& exchange, Take take) {
  if (exchange->draining()) return false;  // no page is made any more
  // A waiting connection cannot be replaced. So half of the connections are reserved for immediate
  // pages, and half of the rest for other addresses.
  const std::string address = ClientAddress(*exchange);
  if (waiting_ >= std::max(1, connections_ / 2)) return false;
  const auto waiting_there = waiting_by_address_.find(address);
  if (waiting_there != waiting_by_address_.end() &&
      waiting_there->second >= std::max(1, connections_ / 4)) {
    return false;
  }
  ++waiting_;
  ++waiting_by_address_[address];
  std::vector<Taker>& takers = takers_[&page];
  takers.push_back({address, std::move(take)});
  if (takers.size() > 1) return true;
  boost::asio::post(page_thread_.executor(), [this, &page, exchange] {
    exchange->Post([this, &page, answer = page.make()] { Deliver(page, answer); });
  });
  return true;
}

// Sends the page to all requests that arrived while it was made.
void PageHandler::Deliver(const HttpPage& page, const HttpAnswer& answer) {
  const std::vector<Taker> takers = std::exchange(takers_[&page], {});
  waiting_ -= static_cast<int>(takers.size());
  for (const Taker& taker : takers) {
    const auto waiting_there = waiting_by_address_.find(taker.address);
    if (--waiting_there->second == 0) waiting_by_address_.erase(waiting_there);
  }
  for (const Taker& taker : takers) taker.take(answer);
}

class PageServer final : public HttpServer {
 public:
  PageServer(HttpPages pages, const HttpLimits& limits)
      : handler_(std::move(pages), limits.connections), limits_(limits) {}

  ~PageServer() override {
    if (listener_ != nullptr) listener_->Close(std::chrono::milliseconds(0));
    handler_.Close();
  }

  absl::Status Listen(const std::string& listen) {
    const auto make = [this](AcceptedClient client) {
      return std::make_shared<Http1Connection>(handler_, ConnectionLimits(limits_),
                                               std::move(client));
    };
    const ListenerOptions options{.threads = 1,
                                  .connections = static_cast<std::size_t>(limits_.connections)};
    auto listener = Listener::Start(listen, options, make, meter_);
    if (!listener.ok()) {
      return absl::Status(listener.status().code(),
                          fmt::format("HTTP: {}", std::string(listener.status().message())));
    }
    listener_ = *std::move(listener);
    is_loopback_ = IsLoopback(listen);
    address_ = fmt::format("{}:{}", listen.substr(0, listen.rfind(':')), listener_->port());
    return absl::OkStatus();
  }

  const std::string& address() const override { return address_; }
  bool is_loopback() const override { return is_loopback_; }

 private:
  PageHandler handler_;
  const HttpLimits limits_;
  ConnectionMeter meter_;
  std::string address_;
  bool is_loopback_ = false;
  std::unique_ptr<Listener> listener_;  // uses the members above
};

}  // namespace

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& listen,
                                                              HttpPages pages, HttpLimits limits) {
  auto server = std::make_unique<PageServer>(std::move(pages), limits);
  MOTIONDB_RETURN_IF_ERROR(server->Listen(listen));
  return server;
}

absl::StatusOr<std::unique_ptr<HttpServer>> StartHealthServer(const std::string& listen,
                                                              const Monitor& monitor,
                                                              LogFormat format) {
  if (listen == "none") return nullptr;
  const bool is_explicit = !listen.empty();
  auto server = HttpServer::Start(is_explicit ? listen : kDefaultHttpListen, HealthPages(monitor));
  if (!is_explicit && absl::IsUnavailable(server.status())) {
    spdlog::warn("no metrics and health pages: {}; set another address with --http-listen",
                 std::string(server.status().message()));
    return nullptr;
  }
  if (!server.ok()) return server.status();
  spdlog::info("metrics and health pages at http://{}/", (*server)->address());
  if (!(*server)->is_loopback()) {
    PrintAlways(
        format,
        fmt::format("http://{}/ has no authentication and no encryption: everyone who can reach it "
                    "can read the names, sizes and load of databases, but no motion, and cannot "
                    "change anything",
                    (*server)->address()));
  }
  return server;
}

namespace {

HttpAnswer Metrics(const Monitor& monitor) {
  return {.content_type = "text/plain; version=0.0.4; charset=utf-8", .body = monitor.Exposition()};
}

// With 503 a load balancer sends no calls here.
HttpAnswer Ready(const Monitor& monitor) {
  const Readiness readiness = monitor.CheckReadiness();
  return {.status = readiness.ready ? 200U : 503U, .body = readiness.reason + "\n"};
}

// If an exception occurs, such as out of memory, only this page fails.
HttpPage CatchExceptions(std::function<HttpAnswer()> make) {
  return {.make = [make = std::move(make)]() -> HttpAnswer {
    try {
      const AllocationsMayFail scope;
      return make();
    } catch (const std::exception& error) {
      return {.status = 500, .body = std::string(error.what()) + "\n"};
    }
  }};
}

}  // namespace

HttpPages HealthPages(const Monitor& monitor) {
  HttpPages pages;
  pages["/metrics"] = CatchExceptions([&monitor] { return Metrics(monitor); });
  pages["/readyz"] = CatchExceptions([&monitor] { return Ready(monitor); });
  // Does not check the store: a restart does not help if the disk hangs.
  pages["/livez"] = {.make = [] { return HttpAnswer{.body = "alive\n"}; }, .is_immediate = true};
  pages["/"] = {
      .make =
          [] {
            return HttpAnswer{
                .body =
                    "/metrics  metrics for Prometheus\n"
                    "/livez    200 while the process responds\n"
                    "/readyz   200 while queries are answered and clips are stored, else 503\n"};
          },
      .is_immediate = true};
  return pages;
}

}  // namespace motiondb::server
