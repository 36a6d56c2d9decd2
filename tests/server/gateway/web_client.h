// A client of HTTP/1.1 on a plain socket, which sends any bytes and reads responses.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/raw_call.h"

namespace motiondb::tests {

struct HttpReply {
  int status = 0;  // 0: the server closed the connection without a response
  std::map<std::string, std::string> fields;  // names in lower case
  std::string body;                           // without chunks
  std::vector<std::string> chunks;

  std::string Field(const std::string& name) const;
};

class WebClient {
 public:
  // `address`: HOST:PORT, also with http:// before it.
  explicit WebClient(const std::string& address);
  ~WebClient();
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  // False: the server has closed the connection.
  bool Send(const std::string& bytes);
  // Reads one response, at most 20 s. `head`: a response without a body.
  HttpReply Read(bool head = false);
  // Reads until the server closes; false after 20 s.
  bool ReadEnd();
  // Ends the sending direction.
  void HalfClose();
  // Closes with a reset.
  void Reset();

 private:
  bool Fill();
  bool ReadLine(std::string& line);
  bool ReadBytes(std::size_t size, std::string& bytes);

  int socket_ = -1;
  std::string buffer_;
};

// Returns a request with Host and, if there is a body or the method is POST, Content-Length.
std::string HttpText(const std::string& method, const std::string& path, const Headers& headers,
                     const std::string& body = "");

// Sends one POST on a connection of its own.
HttpReply Post(const std::string& address, const std::string& path, const Headers& headers,
               const std::string& body);

// Returns the messages of a stream: flags and content.
std::vector<std::pair<int, std::string>> Envelopes(const std::string& body);
std::string EnvelopeText(int flags, const std::string& content);

}  // namespace motiondb::tests
