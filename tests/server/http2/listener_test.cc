// The listener as its clients meet it: addresses, and what is not HTTP/2.
#include "server/http2/listener.h"

#include <grpcpp/create_channel.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <catch2/catch.hpp>
#include <string>

#include "motiondb/v1/database.grpc.pb.h"
#include "tests/support/raw_call.h"
#include "tests/support/test_server.h"

namespace motiondb::tests {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr char kPreface[] = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
const std::string kSettings("\0\0\0\4\0\0\0\0\0", 9);

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
  // Everything until the server closes the connection.
  std::string ReadAll() {
    std::string all;
    boost::system::error_code error;
    asio::read(socket_, asio::dynamic_buffer(all), error);
    return all;
  }

 private:
  asio::io_context context_;
  tcp::socket socket_{context_};
};

std::string Frame(char type, char flags, int stream, const std::string& payload) {
  const auto byte = [](std::size_t number, int shift) {
    return static_cast<char>(number >> shift & 0xff);
  };
  const auto id = static_cast<std::size_t>(stream);
  const std::string head = {byte(payload.size(), 16),
                            byte(payload.size(), 8),
                            byte(payload.size(), 0),
                            type,
                            flags,
                            byte(id, 24),
                            byte(id, 16),
                            byte(id, 8),
                            byte(id, 0)};
  return head + payload;
}

TEST_CASE("Listener: an address that another has is reported", "[server][http2]") {
  TestServer server;
  const auto again = server::Listener::Start(server.server().address(), nullptr, nullptr);
  CHECK(absl::IsUnavailable(again.status()));
  CHECK(absl::IsNotFound(server::Listener::Start("192.0.2.1:0", nullptr, nullptr).status()));
}

TEST_CASE("Listener: what is not HTTP/2 is closed", "[server][http2]") {
  TestServer server;
  for (const std::string& bytes :
       {std::string("GET / HTTP/1.1\r\nHost: x\r\n\r\n"),
        std::string("\x16\x03\x01\x02\x00", 5) + std::string(600, 'x'), std::string(100, '\0')}) {
    Client client(server.server().address());
    client.Send(bytes);
    client.ReadAll();  // ends
  }
  server.CreateDatabase("db");
}

TEST_CASE("Listener: headers that never end cost the connection", "[server][http2]") {
  TestServer server;
  Client client(server.server().address());
  client.Send(kPreface + kSettings + Frame(1, 0, 1, std::string(1000, '\x82')));
  for (int i = 0; i < 100; ++i) client.Send(Frame(9, 0, 1, std::string(16'000, '\x82')));
  client.ReadAll();  // ends
  server.CreateDatabase("db");
}

TEST_CASE("Listener: frames without a call end the connection in the end", "[server][http2]") {
  TestServer server;
  Client client(server.server().address());
  client.Send(kPreface + kSettings);
  std::string windows;
  for (int i = 0; i < 1000; ++i) windows += Frame(8, 0, 0, std::string("\0\0\0\0", 4));
  client.Send(windows);  // an increment of 0 is an error of the connection
  client.ReadAll();
  Client patient(server.server().address());
  patient.Send(kPreface + kSettings);
  std::string priorities;
  for (int i = 0; i < 1000; ++i) priorities += Frame(2, 0, 1, std::string("\0\0\0\3\1", 5));
  for (int i = 0; i < 30; ++i) patient.Send(priorities);
  patient.ReadAll();
  server.CreateDatabase("db");
}

TEST_CASE("Listener: a call of a method that nobody has, and none of gRPC", "[server][http2]") {
  TestServer server;
  const grpc::Status unknown = RawCall(server.channel(), "/no.such/Method", "").status;
  CHECK(unknown.error_code() == grpc::StatusCode::UNIMPLEMENTED);
  // Metadata that gRPC itself would end the process for.
  const auto status = RawCall(server.channel(), "/motiondb.v1.DatabaseService/ListDatabases", "",
                              {{"x-request-id", "plain"}, {"motiondb-peer", "ipv4:192.0.2.7:1"}})
                          .status;
  CHECK(status.ok());
}

}  // namespace
}  // namespace motiondb::tests
