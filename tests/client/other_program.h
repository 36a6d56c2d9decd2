// A program that is not motiondbd, behind a port.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>
#include <thread>
#include <utility>

namespace motiondb::tests {

// A port that accepts connections, sends `greeting` and closes them. Without a greeting it never
// responds.
class OtherProgram {
 public:
  explicit OtherProgram(std::string greeting) : greeting_(std::move(greeting)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    listening_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    REQUIRE(bind(listening_, reinterpret_cast<sockaddr*>(&address), size) == 0);
    REQUIRE(listen(listening_, 16) == 0);
    getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &size);
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    if (!greeting_.empty()) thread_ = std::thread([this] { Greet(); });
  }
  OtherProgram(const OtherProgram&) = delete;
  OtherProgram& operator=(const OtherProgram&) = delete;
  ~OtherProgram() {
    shutdown(listening_, SHUT_RDWR);
    if (thread_.joinable()) thread_.join();
    close(listening_);
  }

  const std::string& address() const { return address_; }

 private:
  void Greet() const {
    for (int caller; (caller = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC)) >= 0;) {
      char asked[4096];
      static_cast<void>(!read(caller, asked, sizeof(asked)));
      static_cast<void>(!write(caller, greeting_.data(), greeting_.size()));
      shutdown(caller, SHUT_WR);
      static_cast<void>(!read(caller, asked, sizeof(asked)));
      close(caller);
    }
  }

  const std::string greeting_;
  int listening_ = -1;
  std::string address_;
  std::thread thread_;
};

}  // namespace motiondb::tests
