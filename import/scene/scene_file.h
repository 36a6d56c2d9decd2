// Reads the bytes of an animated scene with assimp, isolated from the file system.
#pragma once

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/file_format.h"
#include "core/format/motion_file.h"
#include "import/scene/key_curves.h"

namespace motiondb::importer {

// A scene in the file's axes. Its unit is the file's, but for Collada (see StatedConventions).
struct SceneFile {
  std::unique_ptr<Assimp::Importer> importer;  // owns the scene
  const aiScene* scene = nullptr;
  SceneCurves curves = {};  // of glTF
  // Of frames whose keys are those of the file: `asset.extras.frame_rate_hz` of glTF.
  std::optional<double> key_rate_hz = {};
  std::vector<std::string> notes = {};  // what assimp could not read
};

// Reads FBX, glTF 2.0 (text or binary, so also VRM) or Collada. Only the reader of that format
// looks at the bytes, and no other file is opened. Meshes are read as far as needed to know their
// bones. FBX nodes keep their chains of "$AssimpFbx$" nodes (see SceneNodes): without them,
// assimp 5.2.5 loses the animation of nodes with pivots and inverts post-rotations. glTF is checked
// before assimp reads it (see CheckGltf).
//
// Replaces assimp's logger, which is global. INVALID_ARGUMENT with the file's name: assimp's own
// message, the name of a file that the scene refers to, or a variant of the format that is not
// read. Throws only std::bad_alloc.
absl::StatusOr<SceneFile> LoadScene(core::FileFormat format, core::SourceFile file);

}  // namespace motiondb::importer
