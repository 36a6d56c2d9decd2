// The contract of readers and writers of annotations.
#pragma once

#include <cstddef>
#include <cstdint>

#include "client/include/motiondb/annotation_file.h"

namespace motiondb::tests {

// Reads the input. Aborts unless it gives an error, or valid annotations that are the same after
// they are written and read again. BABEL, which has no tracks, is only read.
void CheckAnnotationReader(client::AnnotationFormat format, const std::uint8_t* data,
                           std::size_t size);

}  // namespace motiondb::tests
