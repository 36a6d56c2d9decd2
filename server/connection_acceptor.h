// Takes connections, and gives them to gRPC. gRPC 1.51 can listen itself, but gives its port up,
// for good and without a word, at the first connection for which there is no descriptor. This
// leaves some for everything else, refuses connections beyond, and goes on when others have ended.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::server {

// Lets the process open as many files as it may, up to those of the most connections that are
// taken. For whoever starts it, before anything else.
void RaiseDescriptorLimit();

class ConnectionAcceptor {
 public:
  // Takes over the descriptor of a connection, which came by that of a listener. On a thread of the
  // acceptor's own.
  using Take = std::function<void(int connection, int listener)>;

  // Listens at HOST:PORT, at each address that the host has; port 0 is one that is free. The codes
  // of ListenOn.
  static absl::StatusOr<std::unique_ptr<ConnectionAcceptor>> Start(const std::string& listen,
                                                                   Take take);
  // No connection is taken from then on.
  ~ConnectionAcceptor();

  int port() const;

 private:
  using Acceptor = boost::asio::ip::tcp::acceptor;

  explicit ConnectionAcceptor(Take take);
  absl::Status Listen(const std::string& listen);
  void Await(Acceptor& acceptor);
  void Accept(Acceptor& acceptor);
  void Admit(int connection, Acceptor& acceptor);

  const Take take_;
  const int most_descriptors_;
  boost::asio::io_context context_;
  std::vector<Acceptor> acceptors_;
  std::chrono::steady_clock::time_point warned_;  // epoch: never
  std::thread thread_;
};

}  // namespace motiondb::server
