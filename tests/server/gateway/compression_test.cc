// Compression of responses of the HTTP API.
#include <catch2/catch.hpp>
#include <string>

#include "server/gateway/http_content.h"
#include "tests/server/gateway/web_client.h"
#include "tests/server/gateway/web_server.h"

namespace motiondb::tests::compression_test {
namespace {

constexpr char kList[] = "/motiondb.v1.DatabaseService/ListDatabases";
const std::pair<std::string, std::string> kJson{"Content-Type", "application/json"};

std::string Unzipped(const std::string& bytes) {
  const auto content = server::Gunzip(bytes, [](std::int64_t) { return absl::OkStatus(); });
  REQUIRE(content.ok());
  return *content;
}

TEST_CASE("Connect: responses are compressed if the client accepts it", "[server][gateway]") {
  WebServer server;
  for (int i = 0; i < 30; ++i)
    server->CreateDatabase("database-with-a-long-name-" + std::to_string(i));
  const HttpReply plain = Post(server.address(), kList, {kJson}, "{}");
  REQUIRE(plain.status == 200);
  REQUIRE(plain.body.size() > 1024);
  CHECK(plain.Field("content-encoding").empty());
  for (const char* const accepted : {"gzip", "br, gzip", "GZIP;q=0.5, *"}) {
    const HttpReply reply =
        Post(server.address(), kList, {kJson, {"Accept-Encoding", accepted}}, "{}");
    REQUIRE(reply.status == 200);
    REQUIRE(reply.Field("content-encoding") == "gzip");
    CHECK(reply.body.size() < plain.body.size() / 2);
    CHECK(Unzipped(reply.body) == plain.body);
  }
  // Without Accept-Encoding the client accepts what it sends.
  const HttpReply same =
      Post(server.address(), kList, {kJson, {"Content-Encoding", "gzip"}}, server::Gzip("{}"));
  CHECK(same.Field("content-encoding") == "gzip");
  for (const char* const refused : {"br", "identity", "gzip;q=0"}) {
    const HttpReply reply =
        Post(server.address(), kList, {kJson, {"Accept-Encoding", refused}}, "{}");
    CHECK(reply.Field("content-encoding").empty());
    CHECK(reply.body == plain.body);
  }
}

TEST_CASE("Connect: compressed bodies of a client reserve what they can become",
          "[server][gateway]") {
  WebServer server;
  server->options().calls.message_memory_bytes = 64 << 20;  // half of it for a client
  server->Restart();
  // They can become 22 MB, before it is known who sends them.
  std::string head =
      HttpText("POST", kList, {kJson, {"Content-Encoding", "gzip"}, {"Expect", "100-continue"}},
               std::string(22000, 'x'));
  head.resize(head.find("\r\n\r\n") + 4);
  WebClient first(server.address());
  first.Send(head);
  CHECK(first.Read(/*head=*/true).status == 100);
  WebClient second(server.address());
  second.Send(head);
  CHECK(second.Read().status == 429);
  CHECK(Post(server.address(), kList, {kJson}, "{}").status == 200);
}

TEST_CASE("Connect: a lack of memory is no request that is too large", "[server][gateway]") {
  WebServer server;
  server->options().calls.message_memory_bytes = 32 << 20;
  server->Restart();
  const auto status = [&](std::size_t size) {
    const std::string body = R"({"pageToken":")" + std::string(size, 'a') + "\"}";
    return Post(server.address(), kList, {kJson}, body).status;
  };
  CHECK(status(5 << 20) == 429);  // of 16 MiB, JSON needs four times its size
  CHECK(status(25 << 20) == 413);
}

TEST_CASE("Gzip: bytes come out again, and corrupt data is an error", "[server][gateway]") {
  const auto admit = [](std::int64_t bytes) {
    return bytes <= 1 << 20 ? absl::OkStatus() : absl::ResourceExhaustedError("too large");
  };
  for (const std::size_t size : {0, 1, 1000, 100'000}) {
    std::string text(size, 'a');
    for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * i % 251);
    const std::string zipped = server::Gzip(text);
    CHECK(*server::Gunzip(zipped, admit) == text);
    for (const std::string& broken :
         {zipped.substr(0, zipped.size() - 1), zipped + "x", "x" + zipped, std::string()}) {
      CHECK(absl::IsInvalidArgument(server::Gunzip(broken, admit).status()));
    }
  }
  const std::string bomb = server::Gzip(std::string(2 << 20, '\0'));
  CHECK(absl::IsResourceExhausted(server::Gunzip(bomb, admit).status()));
}

}  // namespace
}  // namespace motiondb::tests::compression_test
