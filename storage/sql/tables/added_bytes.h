// The size of additions to a store, for the check of its room and of shared transactions.
#pragma once

#include <cstdint>

#include "storage/records.h"

namespace motiondb::core {
class Model;
}

namespace motiondb::storage {

// Returns the bytes that adding the clip writes, without the record and the encoded skeleton (some
// kilobytes).
std::int64_t AddedBytes(const NewClip& clip);
// Includes the source files, which are written again with new states.
std::int64_t AddedBytes(const DerivedClip& clip);
// Encodes the model to count its bytes.
std::int64_t AddedBytes(const core::Model& model);

}  // namespace motiondb::storage
