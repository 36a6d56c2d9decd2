// Unit, up axis and frame rate that a scene's file states.
#pragma once

#include <assimp/scene.h>

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/file_format.h"
#include "core/format/motion_file.h"

namespace motiondb::importer {

struct StatedConventions {
  std::optional<double> metres_per_unit = {};
  std::optional<core::UpAxis> up_axis = {};
  std::optional<double> frame_rate_hz = {};
  double scene_units_per_unit = 1;  // assimp applies Collada's unit to the scene
};

// FBX: UnitScaleFactor (cm), UpAxis and UpAxisSign, and the frame rate of its time mode. glTF:
// metre and y, by the format. Collada: `meter` of <unit> and <up_axis> of the file's <asset>; the
// format's defaults do not count as stated. `notes` gets values that cannot be used.
// INVALID_ARGUMENT if Collada's unit is zero, not finite or beyond 1e-9 m to 1e9 m: assimp has
// applied it.
absl::StatusOr<StatedConventions> FindStatedConventions(core::FileFormat format,
                                                        core::SourceFile file, const aiScene& scene,
                                                        std::vector<std::string>& notes);

}  // namespace motiondb::importer
