#include "server/gateway/envelope.h"

#include "core/motion/error.h"
#include "server/http2/message_prefix.h"

namespace motiondb::server {

absl::StatusOr<Envelope> ParseEnvelope(std::string_view body) {
  if (body.empty()) return core::InvalidArgument("expected one request message, got none");
  if (body.size() < kMessagePrefixBytes) {
    return core::InvalidArgument("expected an envelope of at least {} bytes, got {}",
                                 kMessagePrefixBytes, body.size());
  }
  MessagePrefix prefix;
  for (std::size_t i = 0; i < prefix.size(); ++i) prefix[i] = static_cast<std::uint8_t>(body[i]);
  if ((prefix[0] & ~kCompressed) != 0) {
    return core::InvalidArgument("envelope: expected flags 0 or 1, got {}", prefix[0]);
  }
  const std::uint32_t length = MessageLength(prefix);
  body.remove_prefix(kMessagePrefixBytes);
  if (body.size() < length) {
    return core::InvalidArgument("envelope: expected {} bytes, got {}", length, body.size());
  }
  if (body.size() > length) {
    return core::InvalidArgument("expected one request message; {} bytes follow it",
                                 body.size() - length);
  }
  return Envelope{.compressed = prefix[0] == kCompressed, .message = body};
}

std::string MakeEnvelope(std::uint8_t flags, std::string_view message) {
  MessagePrefix prefix = MakeMessagePrefix(static_cast<std::uint32_t>(message.size()));
  prefix[0] = flags;
  std::string envelope(reinterpret_cast<const char*>(prefix.data()), prefix.size());
  return envelope.append(message);
}

}  // namespace motiondb::server
