// What assimp 5.2 lacks for glTF: checks before it reads a file, and the curves of the animations
// that it loses.
#pragma once

#include <assimp/scene.h>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "import/scene/gltf_document.h"
#include "import/scene/scene_file.h"

namespace motiondb::importer {

// Checks what assimp 5.2 reads without a check of its own: it would read memory outside of an
// array or without a value.
// - Accessors: see GltfDocument::Accessor; also the component type of sparse indices.
// - Samplers of animations: interpolation; times are floats; values have the type of their path and
//   as many elements as the times need.
// INVALID_ARGUMENT with the file's name and the path of the value. O(accessors + channels).
absl::Status CheckGltf(const GltfDocument& document);

// Whether an animation has steps, cubic splines or normalized integers.
bool NeedsGltfCurves(const GltfDocument& document);

// Returns the curves of the scene's channels. Replaces the values of keys that are normalized
// integers, which assimp takes for floats. INVALID_ARGUMENT with the file's name and the accessor's
// path: see GltfDocument::Numbers. REQUIRES: CheckGltf accepts the document, and assimp made the
// scene from it. O(keys).
absl::StatusOr<SceneCurves> ReadGltfCurves(const GltfDocument& document, const aiScene& scene);

}  // namespace motiondb::importer
