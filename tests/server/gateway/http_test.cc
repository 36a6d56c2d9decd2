// HTTP/1.1 at the HTTP API: keep-alive, pipelining, chunks, Expect, invalid and hostile requests,
// slow and disappearing clients, drain.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "server/gateway/http_content.h"
#include "tests/server/gateway/web_client.h"
#include "tests/server/gateway/web_server.h"

namespace motiondb::tests::http_test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

constexpr char kList[] = "/motiondb.v1.DatabaseService/ListDatabases";
constexpr char kGet[] = "/motiondb.v1.DatabaseService/GetDatabase";
const std::pair<std::string, std::string> kJson{"Content-Type", "application/json"};

std::string ListText(const std::string& body = "{}") {
  return HttpText("POST", kList, {kJson}, body);
}

// A valid call must succeed after whatever happened.
void CheckServes(WebServer& server) {
  CHECK(Post(server.address(), kList, {kJson}, "{}").status == 200);
}

TEST_CASE("HTTP: requests on one connection, also pipelined", "[server][gateway]") {
  WebServer server;
  WebClient client(server.address());
  for (int i = 0; i < 3; ++i) {
    client.Send(ListText());
    CHECK(client.Read().status == 200);
  }
  const int kPipelined = 50;
  std::string all;
  for (int i = 0; i < kPipelined; ++i) all += i % 2 == 0 ? ListText() : HttpText("GET", "/", {});
  client.Send(all);
  for (int i = 0; i < kPipelined; ++i) CHECK(client.Read().status == (i % 2 == 0 ? 200 : 404));
}

TEST_CASE("HTTP: a body in chunks, sent byte by byte", "[server][gateway]") {
  WebServer server;
  WebClient client(server.address());
  const std::string request = std::string("POST ") + kGet +
                              " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                              "Transfer-Encoding: chunked\r\n\r\n"
                              "9;name=value\r\n{\"name\":\"\r\nE\r\ndatabases/none\r\n2\r\n\"}\r\n"
                              "0\r\nTrailer: x\r\n\r\n";
  for (const char byte : request) REQUIRE(client.Send(std::string(1, byte)));
  const HttpReply reply = client.Read();
  CHECK(reply.status == 404);
  CHECK(json::parse(reply.body).at("code") == "not_found");
  client.Send(ListText());
  CHECK(client.Read().status == 200);
}

TEST_CASE("HTTP: Expect: 100-continue", "[server][gateway]") {
  WebServer server;
  const auto head = [](const std::string& path, std::size_t size) {
    return "POST " + path + " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" +
           "Expect: 100-continue\r\nContent-Length: " + std::to_string(size) + "\r\n\r\n";
  };
  WebClient client(server.address());
  client.Send(head(kList, 2));
  CHECK(client.Read().status == 100);
  client.Send("{}");
  CHECK(client.Read().status == 200);
  client.Send(head(kList, 2) + "{}");  // the client did not wait
  CHECK(client.Read().status == 200);
  client.Send(head(kList, std::size_t{1} << 30));
  CHECK(client.Read().status == 413);
  WebClient other(server.address());
  other.Send(head("/none", 2));
  CHECK(other.Read().status == 404);
  CHECK(other.ReadEnd());
}

TEST_CASE("HTTP/1.0 and Connection: close", "[server][gateway]") {
  WebServer server;
  WebClient old(server.address());
  old.Send(std::string("POST ") + kList +
           " HTTP/1.0\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{}");
  const HttpReply reply = old.Read();
  CHECK(reply.status == 200);
  CHECK(reply.Field("connection") == "close");
  CHECK(old.ReadEnd());
  WebClient stream(server.address());
  stream.Send(
      "POST /motiondb.v1.StoreService/VerifyStore HTTP/1.0\r\nContent-Type: "
      "application/connect+json\r\nContent-Length: 5\r\n\r\n" +
      EnvelopeText(0, ""));
  CHECK(Envelopes(stream.Read().body).back().second == "{}");  // ends with the connection
  WebClient closing(server.address());
  closing.Send(HttpText("POST", kList, {kJson, {"Connection", "close"}}, "{}"));
  CHECK(closing.Read().Field("connection") == "close");
  CHECK(closing.ReadEnd());
}

TEST_CASE("HTTP: HEAD has no body", "[server][gateway]") {
  WebServer server;
  WebClient client(server.address());
  client.Send(HttpText("HEAD", kList, {}) + ListText());
  const HttpReply reply = client.Read(true);
  CHECK(reply.status == 405);
  CHECK(client.Read().status == 200);
}

TEST_CASE("HTTP: invalid requests", "[server][gateway]") {
  WebServer server;
  struct Invalid {
    const char* name;
    std::string text;
    std::vector<int> statuses;
  };
  const std::string post = std::string("POST ") + kList + " HTTP/1.1\r\n";
  const std::string host = "Host: localhost\r\n";
  const std::string type = "Content-Type: application/json\r\n";
  const std::vector<Invalid> cases = {
      {"garbage", std::string(100, '\xff') + "\r\n\r\n", {400}},
      {"HTTP/2", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", {400, 501, 505}},
      {"TLS", std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11) + "\r\n\r\n", {400}},
      {"no host", post + type + "Content-Length: 2\r\n\r\n{}", {400}},
      {"two hosts", post + host + host + type + "Content-Length: 2\r\n\r\n{}", {400}},
      {"HTTP/1.2", std::string("POST ") + kList + " HTTP/1.2\r\n" + host + "\r\n", {505}},
      {"unknown method", std::string("BREW ") + kList + " HTTP/1.1\r\n" + host + "\r\n", {501}},
      {"no path", "OPTIONS * HTTP/1.1\r\n" + host + "\r\n", {400}},
      {"absolute form", "GET http://localhost/ HTTP/1.1\r\n" + host + "\r\n", {400}},
      {"length and chunks",
       post + host + type +
           "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n",
       {400}},
      {"two lengths",
       post + host + type + "Content-Length: 2\r\nContent-Length: 3\r\n\r\n{} ",
       {400}},
      {"negative length", post + host + type + "Content-Length: -2\r\n\r\n{}", {400}},
      {"coded body", post + host + type + "Transfer-Encoding: gzip\r\n\r\n", {501}},
      {"coded chunks",
       post + host + type + "Transfer-Encoding: gzip, chunked\r\n\r\n0\r\n\r\n",
       {501}},
      {"invalid chunk", post + host + type + "Transfer-Encoding: chunked\r\n\r\nzz\r\n", {400}},
      {"endless chunk line",
       post + host + type + "Transfer-Encoding: chunked\r\n\r\n1;" + std::string(200'000, 'x'),
       {400, 431}},
      {"huge header", post + host + "X: " + std::string(100'000, 'x') + "\r\n\r\n", {431}},
      {"huge path", "POST /" + std::string(100'000, 'x') + " HTTP/1.1\r\n" + host + "\r\n", {431}},
      {"many headers",
       [&] {
         std::string text = post + host;
         for (int i = 0; i < 5000; ++i) text += "X: y\r\n";
         return text + "\r\n";
       }(),
       {431}},
      {"unknown expectation",
       post + host + type + "Expect: x\r\nContent-Length: 2\r\n\r\n{}",
       {417}},
      {"huge length", post + host + type + "Content-Length: 99999999999999\r\n\r\n{}", {413}},
      {"largest length",
       post + host + type + "Content-Length: 18446744073709551615\r\n\r\n{}",
       {413, 400}},
  };
  for (const Invalid& invalid : cases) {
    INFO(invalid.name);
    WebClient client(server.address());
    client.Send(invalid.text);
    const HttpReply reply = client.Read();
    CAPTURE(reply.status, reply.body);
    CHECK(std::ranges::count(invalid.statuses, reply.status) == 1);
    CHECK(reply.Field("connection") == "close");
    CHECK(client.ReadEnd());
  }
  CheckServes(server);
}

TEST_CASE("HTTP: requests that are too large", "[server][gateway]") {
  WebServer server;
  server->options().max_message_bytes = 1 << 20;
  server->Restart();
  const std::string large(3 << 20, ' ');
  const HttpReply announced = Post(server.address(), kList, {kJson}, large + "{}");
  CHECK(announced.status == 413);
  CHECK(json::parse(announced.body).at("code") == "resource_exhausted");
  CHECK(Post(server.address(), kList, {{"Content-Type", "application/proto"}}, large).status ==
        413);

  WebClient chunked(server.address());
  chunked.Send(std::string("POST ") + kList +
               " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
               "Transfer-Encoding: chunked\r\n\r\n");
  const std::string chunk = "10000\r\n" + std::string(0x10000, ' ') + "\r\n";
  for (int i = 0; i < 64 && chunked.Send(chunk); ++i) {
  }
  CHECK(chunked.Read().status == 413);

  // 100 MB of zeros and of spaces in 100 kB: the limit counts decompressed bytes.
  const std::string bomb = server::Gzip(std::string(100 << 20, '\0'));
  REQUIRE(bomb.size() < 1 << 20);
  const HttpReply bombed =
      Post(server.address(), kList,
           {{"Content-Type", "application/proto"}, {"Content-Encoding", "gzip"}}, bomb);
  CHECK(bombed.status == 413);
  const HttpReply streamed =
      Post(server.address(), "/motiondb.v1.StoreService/VerifyStore",
           {{"Content-Type", "application/connect+json"}, {"Connect-Content-Encoding", "gzip"}},
           EnvelopeText(1, server::Gzip(std::string(100 << 20, ' '))));
  CHECK(json::parse(Envelopes(streamed.body).at(0).second).at("error").at("code") ==
        "resource_exhausted");
  CheckServes(server);
}

TEST_CASE("HTTP: deep JSON", "[server][gateway]") {
  WebServer server;
  for (const std::string open : {"{\"filter\":", "[", "{\"a\":[", "{"}) {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += open;
    CHECK(Post(server.address(), kList, {kJson}, text).status == 400);
  }
  CheckServes(server);
}

TEST_CASE("HTTP: slow senders and idle clients are closed", "[server][gateway]") {
  WebServer server;
  server->options().calls.idle_limit = std::chrono::seconds(2);
  server->options().calls.first_idle_limit = milliseconds(1500);
  server->Restart();
  WebClient body(server.address());
  body.Send(ListText().substr(0, ListText().size() - 1));
  WebClient idle(server.address());
  idle.Send(ListText());
  CHECK(idle.Read().status == 200);
  const HttpReply late = body.Read();
  CHECK(late.status == 408);
  CHECK(body.ReadEnd());
  CHECK(idle.ReadEnd());
  CheckServes(server);
}

TEST_CASE("HTTP: clients that disappear", "[server][gateway]") {
  WebServer server;
  server->CreateTrained("demo");
  const std::string stream =
      HttpText("POST", "/motiondb.v1.StoreService/BackupStore",
               {{"Content-Type", "application/connect+json"}}, EnvelopeText(0, "{}"));
  for (int i = 0; i < 20; ++i) {
    WebClient client(server.address());
    client.Send(i % 2 == 0 ? stream : ListText());
    if (i % 3 == 0) client.Reset();
  }
  WebClient half(server.address());
  half.Send(ListText());
  half.HalfClose();
  CHECK(half.Read().status == 200);
  CheckServes(server);
}

TEST_CASE("HTTP: parallel connections", "[server][gateway]") {
  WebServer server;
  server->CreateDatabase("demo");
  std::vector<std::thread> threads;
  std::atomic<int> answered = 0;
  for (int i = 0; i < 16; ++i) {
    threads.emplace_back([&, i] {
      WebClient client(server.address());
      for (int j = 0; j < 50; ++j) {
        const std::string name = "databases/" + std::string(j % 2 == 0 ? "demo" : "none");
        client.Send(HttpText("POST", kGet, {kJson}, json{{"name", name}}.dump()));
        answered += client.Read().status == (j % 2 == 0 ? 200 : 404) ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(answered == 16 * 50);
}

TEST_CASE("HTTP: a drain answers calls and closes connections", "[server][gateway]") {
  WebServer server;
  WebClient idle(server.address());
  idle.Send(ListText());
  REQUIRE(idle.Read().status == 200);
  WebClient busy(server.address());
  busy.Send("POST ");
  const auto before = std::chrono::steady_clock::now();
  server->server().Drain(std::chrono::seconds(10));
  CHECK(std::chrono::steady_clock::now() - before < std::chrono::seconds(5));
  CHECK(idle.ReadEnd());
  CHECK(busy.ReadEnd());
}

}  // namespace
}  // namespace motiondb::tests::http_test
