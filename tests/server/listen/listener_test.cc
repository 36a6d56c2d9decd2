// The listener with real clients: addresses, invalid HTTP/2, limits.
#include "server/listen/listener.h"

#include <grpcpp/create_channel.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "motiondb/v1/database.grpc.pb.h"
#include "tests/server/http2/http2_frame.h"
#include "tests/support/raw_call.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::listener_test {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

class Client {
 public:
  explicit Client(const std::string& address) {
    const std::size_t colon = address.rfind(':');
    asio::connect(socket_, tcp::resolver(context_).resolve(address.substr(0, colon),
                                                           address.substr(colon + 1)));
  }
  void Send(const std::string& bytes) {
    boost::system::error_code error;
    asio::write(socket_, asio::buffer(bytes), error);
  }
  unsigned port() const { return socket_.local_endpoint().port(); }

  // Reads until the server closes the connection.
  std::string ReadAll() {
    std::string all;
    boost::system::error_code error;
    asio::read(socket_, asio::dynamic_buffer(all), error);
    return all;
  }

  // Reads until `text`, or until the server closes the connection.
  std::string ReadUntil(const std::string& text) {
    std::string all;
    boost::system::error_code error;
    asio::read_until(socket_, asio::dynamic_buffer(all), text, error);
    return all;
  }

 private:
  asio::io_context context_;
  tcp::socket socket_{context_};
};

// HPACK header block: POST, http, an authority, the path, and the content type. Fields are literals
// without indexing.
std::string CallHeaders(const std::string& path) {
  const auto literal = [](const std::string& text) {
    return std::string(1, static_cast<char>(text.size())) + text;
  };
  return "\x83\x86\x01" + literal("motiondb") + std::string("\x04") + literal(path) +
         std::string("\x0f\x10") + literal("application/grpc");
}

constexpr char kListDatabases[] = "/motiondb.v1.DatabaseService/ListDatabases";

// The beginning of a GOAWAY frame, without its length.
std::string GoAway(std::uint32_t last_stream) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes += static_cast<char>(last_stream >> shift & 0xff);
  }
  return Http2Frame(7, 0, 0, bytes).substr(3);
}

// Returns the kind of timer that the system runs for the connection from `local` to `remote`, ports
// of this machine; empty: there is no such connection.
std::string TimerOf(unsigned local, unsigned remote) {
  std::ifstream connections("/proc/net/tcp");
  std::string line;
  std::getline(connections, line);
  while (std::getline(connections, line)) {
    std::istringstream words(line);
    std::string number, from, to, state, queues, timer;
    words >> number >> from >> to >> state >> queues >> timer;
    const auto port = [](const std::string& address) {
      return std::stoul(address.substr(address.rfind(':') + 1), nullptr, 16);
    };
    if (port(from) == local && port(to) == remote) return timer.substr(0, timer.find(':'));
  }
  return "";
}

TEST_CASE("Listener: the system probes silent connections", "[server][http2]") {
  TestServer server;
  const std::string address = server.server().address();
  const auto port = static_cast<unsigned>(std::stoul(address.substr(address.rfind(':') + 1)));
  const Client client(address);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  const std::string kProbes = "02";  // 01: data is not acknowledged yet
  while (TimerOf(port, client.port()) != kProbes && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(TimerOf(port, client.port()) == kProbes);
}

TEST_CASE("Listener: an address in use is reported", "[server][http2]") {
  TestServer server;
  server::ConnectionMeter meter;
  const auto again = server::Listener::Start(server.server().address(), {}, nullptr, meter);
  CHECK(absl::IsUnavailable(again.status()));
  CHECK(absl::IsNotFound(server::Listener::Start("192.0.2.1:0", {}, nullptr, meter).status()));
}

TEST_CASE("Listener: closing while its timers expire ends all threads", "[server][http2]") {
  using std::chrono::microseconds;
  server::ConnectionMeter meter;
  std::vector<std::pair<std::unique_ptr<server::Listener>, std::chrono::steady_clock::time_point>>
      listeners;
  for (int i = 0; i < 100; ++i) {
    auto listener = server::Listener::Start("127.0.0.1:0", {}, nullptr, meter);
    REQUIRE(listener.ok());
    listeners.emplace_back(*std::move(listener), std::chrono::steady_clock::now());
  }
  for (std::size_t i = 0; i < listeners.size(); ++i) {
    const auto& [listener, started] = listeners[i];
    std::this_thread::sleep_until(started + microseconds(999'900 + 4 * i));  // a tick is 1 s
    listener->Close(std::chrono::milliseconds(0));
  }
  listeners.clear();  // must return
}

TEST_CASE("Listener: a drain refuses connections, and serves calls of the others at first",
          "[server][http2]") {
  TestServer server;
  Client client(server.server().address());
  client.Send(kHttp2Preface + kHttp2Settings + Http2Frame(6, 0, 0, "received"));
  client.ReadUntil(Http2Frame(6, 1, 0, "received"));
  std::thread draining([&] { server.server().Drain(std::chrono::seconds(10)); });
  client.ReadUntil(GoAway(0x7fffffff));
  CHECK_THROWS(Client(server.server().address()));
  client.Send(Http2Frame(1, 4, 1, CallHeaders(kListDatabases)) +
              Http2Frame(0, 1, 1, std::string(5, '\0')));
  const std::string received = client.ReadAll();
  // The headers of an answer with a message; an error would also end the stream.
  CHECK(received.find(Http2Frame(1, 4, 1, "").substr(3)) != std::string::npos);
  CHECK(received.find(GoAway(1)) != std::string::npos);
  draining.join();
}

// Otherwise gRPC, which is shut down by then, would crash.
TEST_CASE("Listener: no call begins once the listener closes", "[server][http2]") {
  constexpr int kCalls = 40;
  constexpr int kFirstMessage = 2;  // ms after the last GOAWAY
  TestServer server;
  Client client(server.server().address());
  std::string calls = kHttp2Preface + kHttp2Settings;
  // Only headers: such a call begins with its message.
  for (int i = 0; i < kCalls; ++i)
    calls += Http2Frame(1, 4, 2 * i + 1, CallHeaders(kListDatabases));
  client.Send(calls + Http2Frame(6, 0, 0, "received"));
  client.ReadUntil(Http2Frame(6, 1, 0, "received"));
  std::thread draining([&] { server.server().Drain(std::chrono::seconds(10)); });
  client.ReadUntil(GoAway(2 * kCalls - 1));
  for (int i = 0; i < kCalls; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(kFirstMessage));
    client.Send(Http2Frame(0, 1, 2 * i + 1, std::string(5, '\0')));
  }
  draining.join();
}

TEST_CASE("Listener: a connection without HTTP/2 is closed", "[server][http2]") {
  TestServer server;
  for (const std::string& bytes :
       {std::string("GET / HTTP/1.1\r\nHost: x\r\n\r\n"),
        std::string("\x16\x03\x01\x02\x00", 5) + std::string(600, 'x'), std::string(100, '\0')}) {
    Client client(server.server().address());
    client.Send(bytes);
    client.ReadAll();  // must return
  }
  server.CreateDatabase("db");
}

TEST_CASE("Listener: a connection with endless headers is closed", "[server][http2]") {
  TestServer server;
  Client client(server.server().address());
  client.Send(kHttp2Preface + kHttp2Settings + Http2Frame(1, 0, 1, std::string(1000, '\x82')));
  for (int i = 0; i < 100; ++i) client.Send(Http2Frame(9, 0, 1, std::string(16'000, '\x82')));
  client.ReadAll();  // must return
  server.CreateDatabase("db");
}

TEST_CASE("Listener: too many frames without a call end the connection", "[server][http2]") {
  TestServer server;
  Client client(server.server().address());
  client.Send(kHttp2Preface + kHttp2Settings);
  std::string windows;
  for (int i = 0; i < 1000; ++i) windows += Http2Frame(8, 0, 0, std::string("\0\0\0\0", 4));
  client.Send(windows);  // an increment of 0 is a connection error
  client.ReadAll();
  Client patient(server.server().address());
  patient.Send(kHttp2Preface + kHttp2Settings);
  std::string priorities;
  for (int i = 0; i < 1000; ++i) priorities += Http2Frame(2, 0, 1, std::string("\0\0\0\3\1", 5));
  for (int i = 0; i < 30; ++i) patient.Send(priorities);
  patient.ReadAll();
  server.CreateDatabase("db");
}

// gRPC's own clients send it if a call is cancelled as it begins.
TEST_CASE("Listener: a reset of a stream that was never opened ends no other call",
          "[server][http2]") {
  TestServer server;
  Client client(server.server().address());
  const std::string reset = Http2Frame(3, 0, 1, std::string("\0\0\0\x8", 4));
  const std::string call =
      Http2Frame(1, 4, 3, CallHeaders(kListDatabases)) + Http2Frame(0, 1, 3, std::string(5, '\0'));
  client.Send(kHttp2Preface + kHttp2Settings + reset + call);
  const std::string trailers = std::string("\1\5\0\0\0\3", 6);  // start of the final HEADERS frame
  CHECK_THAT(client.ReadUntil(trailers), Catch::Matchers::Contains(trailers));
}

// Waits until `count` connections were ended; the server counts after the client has closed, too.
void AwaitEnded(TestServer& server, std::int64_t count) {
  const auto ended = [&] {
    return server.server().monitor().CollectStatistics().ended_connections;
  };
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (ended() < count && std::chrono::steady_clock::now() < latest) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  CHECK(ended() == count);
}

// A header of 3,000 bytes in HPACK's table, and 100 references to it.
std::string HugeHeaders() {
  return CallHeaders(kListDatabases) + std::string("\x40\x01x\x7f\xb9\x16") +
         std::string(3000, 'v') + std::string(100, '\xbe');
}

TEST_CASE("Listener: connections that the server ends are counted", "[server][http2]") {
  TestServer server;
  const std::string call =
      Http2Frame(1, 4, 1, CallHeaders(kListDatabases)) + Http2Frame(0, 1, 1, std::string(5, '\0'));
  for (int i = 0; i < 5; ++i) {
    Client client(server.server().address());
    client.Send(kHttp2Preface + kHttp2Settings + call + Http2Frame(0, 0, 0, "data of no stream"));
    CHECK_THAT(client.ReadAll(), Catch::Matchers::Contains("DATA: stream_id == 0"));
  }
  server.CreateDatabase("db");
  AwaitEnded(server, 5);
  CHECK(server.server().monitor().CollectStatistics().open_connections == 1);
}

// Regression: a connection that ended in the turn in which a call began was never released, and the
// server did not stop.
TEST_CASE("Listener: a connection that ends as its calls begin is released", "[server][http2]") {
  TestServer server;
  for (int i = 0; i < 20; ++i) {
    Client client(server.server().address());
    client.Send(kHttp2Preface + kHttp2Settings + Http2Frame(1, 4, 1, CallHeaders(kListDatabases)) +
                Http2Frame(1, 5, 3, HugeHeaders()));
    client.ReadAll();  // must return
  }
  server.CreateDatabase("db");
  AwaitEnded(server, 20);
}

TEST_CASE("Listener: an unknown method, and a request that is not gRPC", "[server][http2]") {
  TestServer server;
  const grpc::Status unknown = RawCall(server.channel(), "/no.such/Method", "").status;
  CHECK(unknown.error_code() == grpc::StatusCode::UNIMPLEMENTED);
  // gRPC aborts the process for such metadata.
  const auto status = RawCall(server.channel(), kListDatabases, "",
                              {{"x-request-id", "plain"}, {"motiondb-peer", "ipv4:192.0.2.7:1"}})
                          .status;
  CHECK(status.ok());
}

}  // namespace
}  // namespace motiondb::tests::listener_test
