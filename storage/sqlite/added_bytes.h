// How many bytes of blobs something brings to a store. Writes nothing; safe to call from any
// thread.
#pragma once

#include <cstdint>

#include "storage/records.h"

namespace motiondb::core {
class Model;
}

namespace motiondb::storage {

// A skeleton's own encoding and the record, some kilobytes, are not counted.
std::int64_t AddedBytes(const NewClip& clip);
// Takes as long as copying them does.
std::int64_t AddedBytes(const core::Model& model);

}  // namespace motiondb::storage
