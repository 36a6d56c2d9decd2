// Checks a glTF file before assimp reads it.
#pragma once

#include "absl/status/status.h"
#include "import/scene/gltf_document.h"

namespace motiondb::importer {

// Checks what assimp 5.2 reads without a check of its own: it would read memory outside of an
// array or without a value.
// - Accessors: see GltfDocument::Accessor; also the component type of sparse indices.
// - Samplers of animations: interpolation; times are floats; values have the type of their path and
//   as many elements as the times need.
// INVALID_ARGUMENT with the file's name and the path of the value. O(accessors + channels).
absl::Status CheckGltf(const GltfDocument& document);

}  // namespace motiondb::importer
