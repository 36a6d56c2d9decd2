// The HTTP server over real sockets: proper clients, and slow or hostile ones.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <condition_variable>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/observability/health_server.h"
#include "tests/server/observability/http_client.h"
#include "tests/support/awaited_log.h"

namespace motiondb::tests::http_server_test {
namespace {

using Catch::Contains;
using Catch::EndsWith;
using Catch::StartsWith;
using server::HttpAnswer;
using server::HttpLimits;
using server::HttpServer;
using std::chrono::milliseconds;

const std::string kGet = "GET /page HTTP/1.1\r\nHost: test\r\n\r\n";
const std::string kLastGet = "GET /page HTTP/1.1\r\nHost: test\r\nConnection: close\r\n\r\n";

std::unique_ptr<HttpServer> StartServer(HttpLimits limits = {}, server::HttpPages pages = {}) {
  pages["/page"] = {.make = [] { return HttpAnswer{.body = "made\n"}; }};
  pages["/now"] = {.make = [] { return HttpAnswer{.body = "now\n"}; }, .is_immediate = true};
  pages["/busy"] = {.make = [] { return HttpAnswer{.status = 503, .body = "busy\n"}; }};
  auto server = HttpServer::Start("127.0.0.1:0", std::move(pages), limits);
  INFO(server.status().ToString());
  REQUIRE(server.ok());
  return *std::move(server);
}

TEST_CASE("HttpServer: pages, with their status", "[server][http]") {
  const auto server = StartServer();
  CHECK(server->is_loopback());
  const std::string page = Fetch(server->address(), "/page");
  CHECK_THAT(page, StartsWith("HTTP/1.1 200 OK\r\n") && EndsWith("\r\n\r\nmade\n") &&
                       Contains("content-type: text/plain; charset=utf-8\r\n") &&
                       Contains("content-length: 5\r\n"));
  CHECK_THAT(Fetch(server->address(), "/now?a=b"), EndsWith("\r\n\r\nnow\n"));
  CHECK_THAT(Fetch(server->address(), "/busy"), StartsWith("HTTP/1.1 503 ") && EndsWith("busy\n"));
}

TEST_CASE("HttpServer: HEAD returns only the headers of GET", "[server][http]") {
  const auto server = StartServer();
  CHECK_THAT(Fetch(server->address(), "/page", "HEAD"), StartsWith("HTTP/1.1 200 OK\r\n") &&
                                                            Contains("content-length: 5\r\n") &&
                                                            EndsWith("\r\n\r\n"));
}

TEST_CASE("HttpServer: unknown pages and methods are refused", "[server][http]") {
  const auto server = StartServer();
  for (const char* target : {"/", "/pag", "/page/", "/page/../page", "/%70age"}) {
    CAPTURE(target);
    CHECK_THAT(Fetch(server->address(), target), StartsWith("HTTP/1.1 404 "));
  }
  for (const char* target : {"page", "*"}) {
    CAPTURE(target);
    CHECK_THAT(Fetch(server->address(), target), StartsWith("HTTP/1.1 400 "));
  }
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS"}) {
    CAPTURE(method);
    CHECK_THAT(Fetch(server->address(), "/page", method),
               StartsWith("HTTP/1.1 405 ") && Contains("allow: GET, HEAD\r\n"));
  }
}

TEST_CASE("HttpServer: connections are kept alive, and requests may be pipelined",
          "[server][http]") {
  const auto server = StartServer();
  HttpClient client(server->address());
  client.Send(kGet);
  const std::string first = client.Read(Fetch(server->address(), "/page").size() -
                                        std::string("connection: close\r\n").size());
  CHECK_THAT(first, EndsWith("made\n"));
  client.Send(kGet + kGet + kLastGet);
  const std::string responses = client.ReadToEnd();
  std::size_t answers = 0;
  for (std::size_t at = 0; (at = responses.find("made\n", at)) != std::string::npos; ++at)
    ++answers;
  CHECK(answers == 3);
}

TEST_CASE("HttpServer: HTTP/1.0 closes the connection after the response", "[server][http]") {
  const auto server = StartServer();
  HttpClient client(server->address());
  client.Send("GET /page HTTP/1.0\r\n\r\n");
  CHECK_THAT(client.ReadToEnd(), StartsWith("HTTP/1.0 200") || StartsWith("HTTP/1.1 200"));
}

TEST_CASE("HttpServer: garbage and oversized requests are refused", "[server][http]") {
  const auto server = StartServer();
  const auto answer = [&](const std::string& bytes) {
    HttpClient client(server->address());
    client.Send(bytes);
    return client.ReadToEnd();
  };
  CHECK_THAT(answer("\x16\x03\x01\x02\x00\x01\xfc\x03\x03 hello over TLS\r\n\r\n"),
             StartsWith("HTTP/1.1 400 "));
  CHECK_THAT(answer("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"), StartsWith("HTTP/1.1 505 "));
  CHECK_THAT(answer("GET /page HTTP/1.1\r\nno colon\r\n\r\n"), StartsWith("HTTP/1.1 400 "));
  CHECK_THAT(answer("GET /page HTTP/1.1\r\nContent-Length: -1\r\n\r\n"),
             StartsWith("HTTP/1.1 400 "));
  CHECK_THAT(answer("GET /page HTTP/1.1\r\nX: " + std::string(9000, 'x') + "\r\n\r\n"),
             StartsWith("HTTP/1.1 431 "));
  CHECK_THAT(answer("GET /page HTTP/1.1\r\nHost: a\r\nContent-Length: 1000000\r\n\r\n"),
             StartsWith("HTTP/1.1 413 "));
  CHECK_THAT(Fetch(server->address(), "/page"), StartsWith("HTTP/1.1 200"));
}

TEST_CASE("HttpServer: a client that sends slowly is disconnected", "[server][http]") {
  const auto server = StartServer({.request_time = milliseconds(200)});
  HttpClient silent(server->address());
  HttpClient slow(server->address());
  slow.Send("GET /page HTTP/1.1\r\n");
  std::atomic<bool> stop = false;
  std::thread trickle([&] {
    while (!stop) {
      slow.Send("X: y\r\n");
      std::this_thread::sleep_for(milliseconds(20));
    }
  });
  CHECK_THAT(slow.ReadToEnd(), StartsWith("HTTP/1.1 408 "));
  CHECK(silent.ReadToEnd() == "");
  stop = true;
  trickle.join();
}

TEST_CASE("HttpServer: a client that reads slowly is disconnected", "[server][http]") {
  const AwaitedLog log;
  const auto large = [] { return HttpAnswer{.body = std::string(std::size_t{64} << 20, 'x')}; };
  const auto server =
      StartServer({.answer_time = milliseconds(200)}, {{"/large", {.make = large}}});
  HttpClient client(server->address());
  client.Send("GET /large HTTP/1.1\r\nHost: test\r\n\r\n");
  CHECK(client.Read(1) == "H");  // the response has begun
  CHECK(log.Await("the client reads too slowly"));
  CHECK(client.ReadToEnd().size() < std::size_t{64} << 20);
}

TEST_CASE("HttpServer: clients that hold connections do not lock out others", "[server][http]") {
  constexpr int kLimit = 8;
  const auto server = StartServer({.connections = kLimit, .request_time = std::chrono::hours(1)});
  std::vector<std::unique_ptr<HttpClient>> holding;
  for (int i = 0; i < 5 * kLimit; ++i) {
    holding.push_back(std::make_unique<HttpClient>(server->address()));
    holding.back()->Send("GET /page HTTP/1.1\r\nX:");
    CHECK_THAT(Fetch(server->address(), "/page"), EndsWith("made\n"));
  }
  // The first one was closed for the new connection.
  CHECK(holding.front()->ReadToEnd() == "");
}

TEST_CASE("HttpServer: a slow page does not delay other clients", "[server][http]") {
  std::mutex mutex;
  std::condition_variable changed;
  bool entered = false, open = false;
  const auto hanging = [&] {
    std::unique_lock lock(mutex);
    entered = true;
    changed.notify_all();
    changed.wait(lock, [&] { return open; });
    return HttpAnswer{.body = "at last\n"};
  };
  const auto server = StartServer({.connections = 2}, {{"/hanging", {.make = hanging}}});
  std::string slow_response;
  std::thread waiting([&] { slow_response = Fetch(server->address(), "/hanging"); });
  {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return entered; });
  }
  CHECK_THAT(Fetch(server->address(), "/now"), EndsWith("now\n"));
  {
    const std::lock_guard lock(mutex);
    open = true;
    changed.notify_all();
  }
  waiting.join();
  CHECK_THAT(slow_response, EndsWith("at last\n"));
}

TEST_CASE("HttpServer: clients that wait for a page that hangs do not lock out others",
          "[server][http]") {
  constexpr int kMany = 64;
  std::promise<void> open;
  const std::shared_future<void> opened = open.get_future().share();
  std::atomic<int> made = 0;
  const auto hanging = [&] {
    ++made;
    opened.wait();
    return HttpAnswer{.body = "at last\n"};
  };
  const auto server = StartServer({}, {{"/hanging", {.make = hanging}}});
  const std::string ask = "GET /hanging HTTP/1.1\r\nHost: test\r\nConnection: close\r\n\r\n";
  HttpClient first(server->address());
  first.Send(ask);
  while (made == 0) std::this_thread::sleep_for(milliseconds(1));
  for (int i = 0; i < kMany; ++i) {
    HttpClient(server->address()).Send(ask);
    CHECK_THAT(Fetch(server->address(), "/now"), EndsWith("now\n"));
  }
  std::vector<std::unique_ptr<HttpClient>> waiting;
  for (int i = 0; i < kMany; ++i) {
    waiting.push_back(std::make_unique<HttpClient>(server->address()));
    waiting.back()->Send(ask);
    CHECK_THAT(Fetch(server->address(), "/now"), EndsWith("now\n"));
  }
  CHECK_THAT(waiting.back()->ReadToEnd(),
             StartsWith("HTTP/1.1 503 ") && Contains("too many requests wait"));
  open.set_value();
  CHECK_THAT(first.ReadToEnd(), EndsWith("at last\n"));
  CHECK(made == 1);
  CHECK_THAT(Fetch(server->address(), "/hanging"), EndsWith("at last\n"));
}

TEST_CASE("HttpServer: many concurrent clients", "[server][http]") {
  const auto server = StartServer();
  std::atomic<int> right = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 8; ++i) {
    clients.emplace_back([&] {
      for (int round = 0; round < 50; ++round) {
        if (Fetch(server->address(), "/page").ends_with("made\n")) ++right;
      }
    });
  }
  for (std::thread& client : clients) client.join();
  CHECK(right == 8 * 50);
}

TEST_CASE("HttpServer: stops while clients are connected", "[server][http]") {
  auto server = StartServer();
  HttpClient idle(server->address());
  HttpClient half(server->address());
  half.Send("GET /pa");
  CHECK_THAT(Fetch(server->address(), "/page"), EndsWith("made\n"));
  server.reset();
  CHECK(idle.ReadToEnd() == "");
}

TEST_CASE("HttpServer: an address in use, and invalid addresses", "[server][http]") {
  const auto server = StartServer();
  CHECK(absl::IsUnavailable(HttpServer::Start(server->address(), {}).status()));
  for (const char* address : {"", "127.0.0.1", ":80", "127.0.0.1:", "127.0.0.1:http", "[::1]"}) {
    CAPTURE(address);
    CHECK(absl::IsInvalidArgument(HttpServer::Start(address, {}).status()));
  }
}

}  // namespace
}  // namespace motiondb::tests::http_server_test
