// Changes a message as a client might that means harm: numbers become huge, tiny, negative or none,
// lists grow and shrink, floats inside packed frames change. Bytes changed at random alone rarely
// are a message with frames that fit its shape.
#pragma once

#include <google/protobuf/message.h>

#include <cstddef>
#include <cstdint>

namespace motiondb::tests {

// For LLVMFuzzerCustomMutator: the new size. `message` is scratch of the input's type.
std::size_t MutateMessage(google::protobuf::Message& message, std::uint8_t* data, std::size_t size,
                          std::size_t most, unsigned seed);

}  // namespace motiondb::tests

// The mutator of a target whose inputs are messages of one type.
#define MOTIONDB_MUTATE_AS(Type)                                                       \
  extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, \
                                                 std::size_t most, unsigned seed) {    \
    Type message;                                                                      \
    return motiondb::tests::MutateMessage(message, data, size, most, seed);            \
  }
