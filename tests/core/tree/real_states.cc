#include "tests/core/tree/real_states.h"

#include <catch2/catch.hpp>
#include <vector>

#include "core/format/marker_set_file.h"
#include "core/motion/states.h"
#include "core/tree/feature_scale.h"
#include "tests/support/real_data.h"

namespace motiondb::tests {

core::FrameMatrix LoadScaledStates(const std::string& list, double frame_rate_hz,
                                   const std::function<bool(const ListedClip&)>& wanted) {
  const auto listed = ReadClipList(DataDir() / list);
  REQUIRE(listed.ok());
  std::vector<core::FrameMatrix> clips;
  Eigen::Index frames = 0;
  for (const ListedClip& clip : *listed) {
    if (!wanted(clip)) continue;
    const auto file = ReadMotion(clip.path);
    REQUIRE(file.ok());
    const auto sequence = core::Represent(core::StandardScheme(), file->motion, frame_rate_hz,
                                          core::GlitchPolicy::kKeep);
    REQUIRE(sequence.ok());
    clips.push_back(sequence->states);
    frames += clips.back().rows();
  }
  REQUIRE(frames > 0);
  core::FrameMatrix states(frames, clips[0].cols());
  Eigen::Index at = 0;
  for (const core::FrameMatrix& clip : clips) {
    states.middleRows(at, clip.rows()) = clip;
    at += clip.rows();
  }
  core::MakeFeatureScale(core::Scaling::kKind, states).Apply(states);
  return states;
}

}  // namespace motiondb::tests
