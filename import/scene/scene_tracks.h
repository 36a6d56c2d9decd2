// How nodes move in a take: the keys of its channels, checked, and their interpolation.
#pragma once

#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/file_format.h"
#include "import/scene/scene_file.h"
#include "import/scene/scene_nodes.h"
#include "import/scene/scene_skeleton.h"

namespace motiondb::importer {

// A factor of a joint's local transform.
struct TrackPart {
  Eigen::Affine3d rest = Eigen::Affine3d::Identity();  // without channel
  const aiNodeAnim* channel = nullptr;
  const ChannelCurves* curves = nullptr;  // null: all of the channel is linear
  // Applied between rotation and scale of the channel.
  Eigen::Matrix3d after_rotation = Eigen::Matrix3d::Identity();
};

// The local transform of a joint is the product of its parts, leftmost first.
struct JointTrack {
  Eigen::Affine3d rest = Eigen::Affine3d::Identity();  // of the node, without the take
  std::vector<TrackPart> parts;
};

// Returns the tracks of the skeleton's joints; `curves` must outlive them. INVALID_ARGUMENT, with
// node and number of the key (from 1), if
// - the take's time has no unit above 0;
// - several nodes have the name of a channel;
// - a channel lacks keys for translation, rotation or scale;
// - a key's time is not finite, before its predecessor's, or negative (FBX: allowed, see TimeTake);
// - a value or a transform is not finite, or a rotation far from a unit quaternion.
absl::StatusOr<std::vector<JointTrack>> FindTracks(
    std::string_view file_name, core::FileFormat format, const std::vector<SceneNode>& nodes,
    const NodePlaces& places, const SceneSkeleton& skeleton, const SceneTake& take,
    const SceneCurves& curves);

// Evaluates a track at times that ascend: between keys linear and spherical interpolation, a step
// at each key, or cubic splines, as the curves tell (glTF 2.0, appendix C); constant before the
// first and after the last. Amortized O(1).
class TrackCursor {
 public:
  // `track` must outlive the cursor.
  explicit TrackCursor(const JointTrack& track);

  // Returns the transform from the joint to its parent. `ticks`: time in the unit of the keys.
  Eigen::Affine3d LocalAt(double ticks);

 private:
  // The last keys at or before the time.
  struct Keys {
    unsigned position = 0;
    unsigned rotation = 0;
    unsigned scale = 0;
  };

  const JointTrack& track_;
  std::vector<Keys> keys_;  // one for each part
};

}  // namespace motiondb::importer
