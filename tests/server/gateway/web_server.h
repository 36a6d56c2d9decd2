// A TestServer with the HTTP API.
#pragma once

#include <string>

#include "tests/support/test_server.h"

namespace motiondb::tests {

class WebServer {
 public:
  WebServer() {
    server_.options().web_listen = "127.0.0.1:0";
    server_.Restart();
  }

  TestServer* operator->() { return &server_; }
  // URL of the HTTP API.
  std::string address() { return server_.server().web_address(); }

 private:
  TestServer server_;
};

}  // namespace motiondb::tests
