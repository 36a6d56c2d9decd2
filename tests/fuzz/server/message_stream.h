// Streams of messages as one input: each message after its length (u16, little-endian).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "tests/fuzz/server/message_mutation.h"

namespace motiondb::tests {

inline std::string LengthPrefixed(const std::string& message) {
  const auto length = static_cast<std::uint16_t>(message.size());
  std::string bytes(sizeof(length), '\0');
  std::memcpy(bytes.data(), &length, sizeof(length));
  return bytes + message;
}

inline std::vector<std::string> SplitStream(const std::uint8_t* data, std::size_t size) {
  std::vector<std::string> messages;
  while (size >= sizeof(std::uint16_t)) {
    std::uint16_t length = 0;
    std::memcpy(&length, data, sizeof(length));
    data += sizeof(length);
    size -= sizeof(length);
    const std::size_t taken = std::min<std::size_t>(length, size);
    messages.emplace_back(reinterpret_cast<const char*>(data), taken);
    data += taken;
    size -= taken;
  }
  return messages;
}

// Calls take(message) for each message until it returns false or a message does not parse.
template <typename Message, typename Take>
void ForEachMessage(const std::uint8_t* data, std::size_t size, const Take& take) {
  for (const std::string& bytes : SplitStream(data, size)) {
    Message message;
    if (!message.ParseFromString(bytes) || !take(message)) return;
  }
}

// For LLVMFuzzerCustomMutator: changes, removes or duplicates one message.
template <typename Message>
std::size_t MutateStream(std::uint8_t* data, std::size_t size, std::size_t max_size,
                         unsigned seed) {
  auto messages = SplitStream(data, size);
  if (messages.empty()) messages.emplace_back();
  const std::size_t at = seed / 8 % messages.size();
  const auto chosen = messages.begin() + static_cast<std::ptrdiff_t>(at);
  if (seed % 8 == 0) {
    messages.erase(chosen);
  } else if (seed % 8 == 1) {
    messages.insert(chosen, std::string(*chosen));
  } else {
    Message message;
    std::string& bytes = *chosen;
    const std::size_t before = bytes.size();
    bytes.resize(std::min<std::size_t>(max_size, UINT16_MAX));
    bytes.resize(MutateMessage(message, reinterpret_cast<std::uint8_t*>(bytes.data()),
                               std::min(before, bytes.size()), bytes.size(), seed));
  }
  std::string stream;
  for (const std::string& message : messages) {
    const std::string next = LengthPrefixed(message);
    if (stream.size() + next.size() <= max_size) stream += next;
  }
  std::copy(stream.begin(), stream.end(), data);
  return stream.size();
}

}  // namespace motiondb::tests

// Defines the mutator of a target whose inputs are streams of messages of one type.
#define MOTIONDB_MUTATE_STREAM_OF(Type)                                                 \
  extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,  \
                                                 std::size_t max_size, unsigned seed) { \
    return motiondb::tests::MutateStream<Type>(data, size, max_size, seed);             \
  }
