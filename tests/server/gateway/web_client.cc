#include "tests/server/gateway/web_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>

namespace motiondb::tests {
namespace {

constexpr int kSeconds = 20;

std::string LowerName(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

}  // namespace

std::string HttpReply::Field(const std::string& name) const {
  const auto found = fields.find(name);
  return found == fields.end() ? "" : found->second;
}

WebClient::WebClient(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  sockaddr_in server{};
  server.sin_family = AF_INET;
  server.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
  server.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  REQUIRE(socket_ >= 0);
  const timeval limit{.tv_sec = kSeconds, .tv_usec = 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof(limit));
  REQUIRE(connect(socket_, reinterpret_cast<const sockaddr*>(&server), sizeof(server)) == 0);
}

WebClient::~WebClient() {
  if (socket_ >= 0) close(socket_);
}

bool WebClient::Send(const std::string& bytes) {
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t size = send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (size <= 0) return false;
    sent += static_cast<std::size_t>(size);
  }
  return true;
}

bool WebClient::Fill() {
  char bytes[65536];
  const ssize_t size = recv(socket_, bytes, sizeof(bytes), 0);
  if (size > 0) buffer_.append(bytes, static_cast<std::size_t>(size));
  return size > 0;
}

bool WebClient::ReadLine(std::string& line) {
  std::size_t end;
  while ((end = buffer_.find("\r\n")) == std::string::npos) {
    if (!Fill()) return false;
  }
  line = buffer_.substr(0, end);
  buffer_.erase(0, end + 2);
  return true;
}

bool WebClient::ReadBytes(std::size_t size, std::string& bytes) {
  while (buffer_.size() < size) {
    if (!Fill()) return false;
  }
  bytes = buffer_.substr(0, size);
  buffer_.erase(0, size);
  return true;
}

HttpReply WebClient::Read(bool head) {
  HttpReply reply;
  std::string line;
  if (!ReadLine(line)) return reply;
  REQUIRE(line.size() >= 12);
  REQUIRE(line.substr(0, 9) == "HTTP/1.1 ");
  reply.status = std::stoi(line.substr(9, 3));
  while (ReadLine(line) && !line.empty()) {
    const std::size_t colon = line.find(": ");
    REQUIRE(colon != std::string::npos);
    std::string& value = reply.fields[LowerName(line.substr(0, colon))];
    value += (value.empty() ? "" : ", ") + line.substr(colon + 2);
  }
  if (head || reply.status == 100) return reply;
  if (reply.fields.contains("content-length")) {
    REQUIRE(ReadBytes(std::stoul(reply.fields["content-length"]), reply.body));
  } else if (reply.Field("transfer-encoding") == "chunked") {
    while (true) {
      REQUIRE(ReadLine(line));
      const std::size_t size = std::stoul(line, nullptr, 16);
      std::string chunk;
      REQUIRE(ReadBytes(size, chunk));
      REQUIRE(ReadLine(line));
      REQUIRE(line.empty());
      if (size == 0) break;
      reply.body += chunk;
      reply.chunks.push_back(std::move(chunk));
    }
  } else {
    while (Fill()) {
    }
    reply.body = std::exchange(buffer_, "");
  }
  return reply;
}

bool WebClient::ReadEnd() {
  errno = 0;
  buffer_.clear();
  while (Fill()) buffer_.clear();
  return errno != EAGAIN && errno != EWOULDBLOCK;
}

void WebClient::HalfClose() { shutdown(socket_, SHUT_WR); }

void WebClient::Reset() {
  const linger now{.l_onoff = 1, .l_linger = 0};
  setsockopt(socket_, SOL_SOCKET, SO_LINGER, &now, sizeof(now));
  close(std::exchange(socket_, -1));
}

std::string HttpText(const std::string& method, const std::string& path, const Headers& headers,
                     const std::string& body) {
  std::string text = method + " " + path + " HTTP/1.1\r\n";
  bool has_host = false;
  for (const auto& [name, value] : headers) {
    has_host = has_host || LowerName(name) == "host";
    text += name + ": " + value + "\r\n";
  }
  if (!has_host) text += "Host: localhost:1\r\n";
  if (method == "POST" || !body.empty()) {
    text += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  }
  return text + "\r\n" + body;
}

HttpReply Post(const std::string& address, const std::string& path, const Headers& headers,
               const std::string& body) {
  WebClient client(address);
  client.Send(HttpText("POST", path, headers, body));
  return client.Read();
}

std::vector<std::pair<int, std::string>> Envelopes(const std::string& body) {
  std::vector<std::pair<int, std::string>> envelopes;
  for (std::size_t at = 0; at < body.size();) {
    REQUIRE(body.size() - at >= 5);
    const auto byte = [&](std::size_t i) {
      return static_cast<std::size_t>(static_cast<unsigned char>(body[at + i]));
    };
    const std::size_t size = byte(1) << 24 | byte(2) << 16 | byte(3) << 8 | byte(4);
    REQUIRE(body.size() - at - 5 >= size);
    envelopes.emplace_back(static_cast<int>(byte(0)), body.substr(at + 5, size));
    at += 5 + size;
  }
  return envelopes;
}

std::string EnvelopeText(int flags, const std::string& content) {
  const auto size = static_cast<std::uint32_t>(content.size());
  std::string text(1, static_cast<char>(flags));
  for (const int shift : {24, 16, 8, 0}) text += static_cast<char>(size >> shift & 0xff);
  return text + content;
}

}  // namespace motiondb::tests
