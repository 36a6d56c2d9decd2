// Reads what assimp 5.2 loses of the animations of a glTF file.
#pragma once

#include <assimp/scene.h>

#include "absl/status/statusor.h"
#include "import/scene/gltf_document.h"
#include "import/scene/key_curves.h"

namespace motiondb::importer {

// Whether an animation has steps, cubic splines or normalized integers.
bool NeedsGltfCurves(const GltfDocument& document);

// Returns the curves of the scene's channels. Replaces the values of keys that are normalized
// integers, which assimp takes for floats. INVALID_ARGUMENT with the file's name and the accessor's
// path: see GltfDocument::Numbers. REQUIRES: CheckGltf accepts the document, and assimp made the
// scene from it. O(keys).
absl::StatusOr<SceneCurves> ReadGltfCurves(const GltfDocument& document, const aiScene& scene);

}  // namespace motiondb::importer
