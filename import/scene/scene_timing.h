// When a take is sampled.
#pragma once

#include <assimp/anim.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "import/scene/scene_nodes.h"
#include "import/scene/scene_tracks.h"

namespace motiondb::importer {

// Returns the ticks of the take's times; assimp's default if the file states none.
double TicksPerSecond(const aiAnimation& animation);

// Frame rates that a file states.
struct StatedRates {
  std::optional<double> display_hz = {};  // of an editor's time line: keys can be sparser
  std::optional<double> keys_hz = {};     // of the keys themselves
};

struct SceneTiming {
  double first_tick = 0;  // of frame 0
  double ticks_per_frame = 0;
  double rate_hz = 0;
  int frames = 0;  // the last is at or before the last key
};

// Maximum number of frames x joints of a take: 200 MB of angles.
inline constexpr double kMaxJointPoses = 4e6;

// A take lasts from the first to the last key of the joints' components that have several keys; a
// take of FBX that begins before 0 is cut there, because assimp moves its begin to 0.
//
// Its rate is that of the component with most keys (usual spacing, core::SnapFrameRate). If they
// are irregular or sparser than 10 Hz, the rate is that of their smallest spacings (5 %), or 30 Hz.
// If the file states a rate of its keys, that one is used unless they are denser, and one key is a
// take of one frame. If it states a rate for display (FBX) that is at least 10 Hz and not below
// that of the keys, that one is used. `notes` gets how a rate was deduced.
//
// INVALID_ARGUMENT if no component has two keys and their rate is not stated, the take has no
// duration, its rate is not core::IsFrameRate, or it has more than kMaxJointPoses. REQUIRES: tracks
// of FindTracks.
absl::StatusOr<SceneTiming> TimeTake(std::string_view file_name, const SceneTake& take,
                                     const std::vector<JointTrack>& tracks,
                                     const StatedRates& stated, std::vector<std::string>& notes);

}  // namespace motiondb::importer
