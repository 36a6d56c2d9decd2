#include "server/observability/http_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <map>
#include <thread>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/observability/http_connection.h"
#include "server/observability/listen_on.h"

namespace motiondb::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

// How long to wait where a connection cannot be taken, as where no descriptor is left.
constexpr std::chrono::milliseconds kRest{100};

class BeastHttpServer final : public HttpServer, public HttpConnectionHost {
  using Take = std::function<void(HttpAnswer)>;

 public:
  BeastHttpServer(HttpPages pages, const HttpLimits& limits)
      : pages_(std::move(pages)), limits_(limits) {}

  ~BeastHttpServer() override {
    makers_.join();
    context_.stop();
    if (talker_.joinable()) talker_.join();
  }

  absl::Status Listen(const std::string& listen) {
    if (const absl::Status status = ListenOn(listen, acceptor_); !status.ok()) {
      return absl::Status(status.code(), fmt::format("HTTP: {}", std::string(status.message())));
    }
    is_loopback_ = acceptor_.local_endpoint().address().is_loopback();
    address_ = fmt::format("{}:{}", listen.substr(0, listen.rfind(':')),
                           acceptor_.local_endpoint().port());
    Accept();
    talker_ = std::thread([this] { context_.run(); });
    return absl::OkStatus();
  }

  const std::string& address() const override { return address_; }
  bool is_loopback() const override { return is_loopback_; }

  const HttpLimits& limits() const override { return limits_; }

  const HttpPage* FindPage(std::string_view path) const override {
    const auto found = pages_.find(path);
    return found == pages_.end() ? nullptr : &found->second;
  }

  bool MakeElsewhere(const HttpPage& page, Take take) override {
    // Half are left to pages made at once: those who wait here cannot be made to make room.
    if (waiting_ >= std::max(1, limits_.connections / 2)) return false;
    ++waiting_;
    std::vector<Take>& takers = takers_[&page];
    takers.push_back(std::move(take));
    if (takers.size() > 1) return true;
    asio::post(makers_, [this, &page] {
      asio::post(context_, [this, &page, answer = page.make()] { Hand(page, answer); });
    });
    return true;
  }

  void OnClosed(HttpConnection& connection) override { connections_.erase(&connection); }

 private:
  void Accept() {
    acceptor_.async_accept([this](const boost::system::error_code& error, tcp::socket socket) {
      if (error) {
        rest_.expires_after(kRest);
        rest_.async_wait([this](const boost::system::error_code& stopped) {
          if (!stopped) Accept();
        });
        return;
      }
      Admit(std::move(socket));
      Accept();
    });
  }

  // Gives all who asked for a page while it was made what came of it.
  void Hand(const HttpPage& page, const HttpAnswer& answer) {
    const std::vector<Take> takers = std::exchange(takers_[&page], {});
    waiting_ -= static_cast<int>(takers.size());
    for (const Take& take : takers) take(answer);
  }

  void Admit(tcp::socket socket) {
    if (static_cast<int>(connections_.size()) >= limits_.connections && !MakeRoom()) return;
    const auto connection = std::make_shared<HttpConnection>(*this, std::move(socket));
    connections_.insert(connection.get());
    connection->Start();
  }

  // Closes the connection that has kept us waiting longest. False where each waits for us.
  bool MakeRoom() {
    HttpConnection* slowest = nullptr;
    for (HttpConnection* const connection : connections_) {
      if (!connection->waiting_since()) continue;
      if (slowest == nullptr || *connection->waiting_since() < *slowest->waiting_since()) {
        slowest = connection;
      }
    }
    if (slowest == nullptr) return false;
    slowest->Close();
    return true;
  }

  const HttpPages pages_;
  const HttpLimits limits_;
  std::string address_;
  bool is_loopback_ = false;
  // Each is kept by what it waits for. Before the context, which ends what they wait for.
  std::unordered_set<HttpConnection*> connections_;
  asio::io_context context_;
  std::map<const HttpPage*, std::vector<Take>> takers_;  // of each page that is being made
  int waiting_ = 0;                                      // of them all
  tcp::acceptor acceptor_{context_};
  asio::steady_timer rest_{context_};
  asio::thread_pool makers_{1};
  std::thread talker_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& listen,
                                                              HttpPages pages, HttpLimits limits) {
  auto server = std::make_unique<BeastHttpServer>(std::move(pages), limits);
  MOTIONDB_RETURN_IF_ERROR(server->Listen(listen));
  return server;
}

}  // namespace motiondb::server
