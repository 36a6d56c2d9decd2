// Reads the bytes of an animated scene with assimp, isolated from the file system.
#pragma once

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/file_format.h"
#include "core/format/motion_file.h"

namespace motiondb::importer {

// How values change between keys.
enum class KeyInterpolation { kLinear, kStep, kCubicSpline };

// One component of a channel.
struct KeyCurve {
  KeyInterpolation interpolation = KeyInterpolation::kLinear;
  // Of a cubic spline, for each key: the tangent before it, then the one after it, in the order of
  // glTF (x, y, z, w) and per tick of the take.
  std::vector<float> tangents = {};
};

struct ChannelCurves {
  KeyCurve translation;
  KeyCurve rotation;
  KeyCurve scale;
};

// Of channels with a component that is not linear.
using SceneCurves = std::unordered_map<const aiNodeAnim*, ChannelCurves>;

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

// Returns a note if the takes of an FBX file, binary or text, have more than one layer each: assimp
// 5.2 does not blend layers, but overwrites the keys of one with those of another, and gives no
// sign of it. Takes and layers are counted in the bytes. O(bytes).
std::optional<std::string> NoteOnFbxLayers(std::string_view bytes);

}  // namespace motiondb::importer
