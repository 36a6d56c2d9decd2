// A client of the HTTP server that sends given bytes over a real socket.
#pragma once

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <string>

namespace motiondb::tests {

class HttpClient {
 public:
  explicit HttpClient(const std::string& address) {
    using boost::asio::ip::tcp;
    const std::size_t colon = address.rfind(':');
    boost::asio::connect(socket_, tcp::resolver(context_).resolve(address.substr(0, colon),
                                                                  address.substr(colon + 1)));
  }

  // Ignores errors: the server may have closed already. Reading the response shows it.
  void Send(const std::string& bytes) {
    boost::system::error_code ignored;
    boost::asio::write(socket_, boost::asio::buffer(bytes), ignored);
  }

  // Reads until the server closes the connection.
  std::string ReadToEnd() {
    std::string bytes;
    boost::system::error_code ended;
    boost::asio::read(socket_, boost::asio::dynamic_buffer(bytes), ended);
    return bytes;
  }

  // Reads `count` bytes, or fewer if the connection ends before.
  std::string Read(std::size_t count) {
    std::string bytes(count, '\0');
    boost::system::error_code ended;
    bytes.resize(boost::asio::read(socket_, boost::asio::buffer(bytes), ended));
    return bytes;
  }

 private:
  boost::asio::io_context context_;
  boost::asio::ip::tcp::socket socket_{context_};
};

// Returns the whole response to one request with `Connection: close`: status line, headers, body.
inline std::string Fetch(const std::string& address, const std::string& target,
                         const std::string& method = "GET") {
  HttpClient client(address);
  client.Send(method + " " + target + " HTTP/1.1\r\nHost: test\r\nConnection: close\r\n\r\n");
  return client.ReadToEnd();
}

}  // namespace motiondb::tests
