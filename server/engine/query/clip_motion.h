// The motion of a stored clip as points, for pictures.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/matrix.h"
#include "core/motion/robot.h"
#include "core/view/clip_picture.h"
#include "server/engine/work/work_options.h"

namespace motiondb::server {

class Engine;

// Points, bones and shapes.
struct Figure {
  std::vector<std::string> marker_names;
  std::vector<core::BoneEnds> marker_bones;
  std::vector<std::string> joint_names;  // empty: no skeleton
  std::vector<core::BoneEnds> joint_bones;
  std::vector<core::LinkVisual> joint_visuals;  // of a robot; only with the joints of a motion
};

// The frames first, first + stride, ... of a clip.
struct FrameRange {
  int first = 0;
  int count = 0;   // in a request, 0: all; fewer if the clip ends before
  int stride = 1;  // in a request, 0: 1
};

// Frames of a clip, at the database's frame rate; m, world, floor at z = 0.
struct ClipMotion {
  Figure figure;
  double frame_rate_hz = 0;
  core::FrameMatrix markers_m;         // frames x 3 N_v
  core::FrameMatrix joints_m;          // frames x 3 * joints; empty if not asked for
  core::FrameMatrix joint_rotations;   // core::JointRotations; empty without joint_visuals
  std::vector<std::uint8_t> contacts;  // core::StandingFeet
  FrameRange requested;                // the frames to show; the clip has them

  int frame_count() const { return static_cast<int>(markers_m.rows()); }
};

// Returns the figure of a database: without joints, and without bones until it has a model, unless
// its markers are the joints of a stored skeleton. Codes: NOT_FOUND; FAILED_PRECONDITION (no marker
// set yet); errors of the store.
absl::StatusOr<Figure> DatabaseFigure(Engine& engine, const std::string& database,
                                      const WorkOptions& terms);

// Returns the figure of a clip (id). Its bones are those of the database's figure; before there is
// a model, those of the clip's own motion. Codes as above.
absl::StatusOr<Figure> ClipFigure(Engine& engine, const std::string& database,
                                  const std::string& clip, const WorkOptions& terms);

// Reads the motion of a clip. With `joints`, reads the file of the clip again and computes the
// joints of its skeleton, and of a robot the visual shapes; a clip without a skeleton has none.
// Long clips and joints are heavy work: see IsHeavyWork. Codes as above; also RESOURCE_EXHAUSTED,
// DATA_LOSS, CANCELLED, those of ReadSource, and FAILED_PRECONDITION if the file no longer gives
// the stored frames (a mapping changed since: reprocess). INVALID_ARGUMENT naming first_frame,
// frame_count or stride.
absl::StatusOr<ClipMotion> ReadClipMotion(Engine& engine, const std::string& database,
                                          const std::string& clip, const FrameRange& requested,
                                          bool joints, const WorkOptions& terms);

}  // namespace motiondb::server
