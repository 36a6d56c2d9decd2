// Clients of HTTP/1.1 that read too slowly, or that go while a request works.
#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/http1/http1_connection.h"
#include "server/listen/listener.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests::http1_test {
namespace {

using boost::asio::ip::tcp;
using server::HttpExchange;
using server::HttpResponse;

// Answers each request with `part`, again and again; with nothing if it is empty.
class Endless final : public server::HttpHandler {
 public:
  explicit Endless(std::string part) : part_(std::move(part)) {}

  std::variant<HttpResponse, std::shared_ptr<server::HttpWork>> Accept(
      const server::HttpRequest& /*request*/,
      const std::shared_ptr<HttpExchange>& exchange) override {
    return std::make_shared<Work>(*this, exchange);
  }
  int cancelled() const { return cancelled_; }

 private:
  struct Work final : server::HttpWork {
    Work(Endless& owner, std::shared_ptr<HttpExchange> exchange)
        : owner_(owner), exchange_(std::move(exchange)) {}
    std::optional<HttpResponse> Admit(std::int64_t /*body_bytes*/) override { return {}; }
    void Start(std::string /*body*/) override {
      if (owner_.part_.empty()) return;
      exchange_->BeginStream({});
      OnSent();
    }
    void OnSent() override { exchange_->SendPart(owner_.part_); }
    void Cancel() override { ++owner_.cancelled_; }

    Endless& owner_;
    const std::shared_ptr<HttpExchange> exchange_;
  };

  const std::string part_;
  std::atomic<int> cancelled_ = 0;
};

class Served {
 public:
  Served(server::HttpHandler& handler, server::Http1Limits limits) {
    const auto make = [&handler, limits](server::AcceptedClient client) {
      return std::make_shared<server::Http1Connection>(handler, limits, std::move(client));
    };
    listener_ = Require(server::Listener::Start("127.0.0.1:0", {}, make, meter_));
  }
  ~Served() { listener_->Close(std::chrono::milliseconds(0)); }

  tcp::socket Connect() {
    tcp::socket socket(context_);
    socket.connect({boost::asio::ip::make_address("127.0.0.1"),
                    static_cast<std::uint16_t>(listener_->port())});
    return socket;
  }

 private:
  server::ConnectionMeter meter_;
  boost::asio::io_context context_;
  std::unique_ptr<server::Listener> listener_;
};

constexpr char kRequest[] = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";

bool Within(std::chrono::seconds limit, const std::function<bool()>& condition) {
  const auto latest = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > latest) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

TEST_CASE("HTTP/1.1: the time to read a response is that of all its parts", "[server][gateway]") {
  Endless handler(std::string(64 << 10, 'x'));
  server::Http1Limits limits;
  limits.answer_time = std::chrono::milliseconds(300);
  limits.bytes_per_millisecond = 1 << 30;  // no more time for more bytes
  Served served(handler, limits);
  tcp::socket slow = served.Connect();
  boost::asio::write(slow, boost::asio::buffer(std::string(kRequest)));
  // Each part is read in time.
  std::vector<char> bytes(64 << 10);
  const bool is_closed = Within(std::chrono::seconds(20), [&] {
    boost::system::error_code error;
    boost::asio::read(slow, boost::asio::buffer(bytes), error);
    return error.failed();
  });
  CHECK(is_closed);
  CHECK(handler.cancelled() == 1);
}

TEST_CASE("HTTP/1.1: a client that goes is noticed behind requests that wait",
          "[server][gateway]") {
  Endless handler("");
  Served served(handler, {});
  const bool resets = GENERATE(false, true);
  tcp::socket client = served.Connect();
  std::string requests = kRequest;
  while (requests.size() < 100'000) requests += kRequest;
  boost::asio::write(client, boost::asio::buffer(requests));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  if (resets) client.set_option(tcp::socket::linger(true, 0));
  CHECK(handler.cancelled() == 0);
  client.close();
  CHECK(Within(std::chrono::seconds(20), [&] { return handler.cancelled() == 1; }));
}

}  // namespace
}  // namespace motiondb::tests::http1_test
