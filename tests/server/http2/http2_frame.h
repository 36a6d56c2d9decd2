// HTTP/2 frames of a client.
#pragma once

#include <cstddef>
#include <string>

namespace motiondb::tests {

inline const std::string kHttp2Preface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
inline const std::string kHttp2Settings("\0\0\0\4\0\0\0\0\0", 9);

inline std::string Http2Frame(char type, char flags, int stream, const std::string& payload) {
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

}  // namespace motiondb::tests
