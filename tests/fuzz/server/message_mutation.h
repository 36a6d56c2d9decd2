// Mutates a message as a hostile client might: numbers become huge, tiny, negative or NaN, lists
// grow and shrink, and floats in packed frames change. Random bytes alone rarely form a message
// whose frames match its shape.
#pragma once

#include <google/protobuf/message.h>

#include <cstddef>
#include <cstdint>

namespace motiondb::tests {

// For LLVMFuzzerCustomMutator. Returns the new size. `message` is scratch of the input's type;
// `max_size` is the maximum size.
std::size_t MutateMessage(google::protobuf::Message& message, std::uint8_t* data, std::size_t size,
                          std::size_t max_size, unsigned seed);

}  // namespace motiondb::tests

// Defines the mutator of a target whose inputs are messages of one type.
#define MOTIONDB_MUTATE_AS(Type)                                                        \
  extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,  \
                                                 std::size_t max_size, unsigned seed) { \
    Type message;                                                                       \
    return motiondb::tests::MutateMessage(message, data, size, max_size, seed);         \
  }
