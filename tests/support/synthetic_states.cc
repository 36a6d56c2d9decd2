#include "tests/support/synthetic_states.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace motiondb::tests {

core::MarkerSet SmallMarkerSet(int markers) {
  core::MarkerSet set;
  set.name = "small";
  for (int m = 0; m < markers; ++m) set.markers.push_back("m" + std::to_string(m));
  set.landmarks.left_hip = 0;
  set.landmarks.right_hip = 1;
  if (markers >= 4) set.landmarks.legs.push_back({0, 2, 3});
  return set;
}

core::FrameMatrix WanderingStates(int frames, int dimensions, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const int places = 5;
  core::FrameMatrix place(places, dimensions);
  for (Eigen::Index i = 0; i < place.size(); ++i) place.data()[i] = 3 * normal(random);
  core::FrameMatrix states(frames, dimensions);
  Eigen::RowVectorXf at = place.row(0);
  int target = 0;
  for (int t = 0; t < frames; ++t) {
    if (t % 20 == 0) target = static_cast<int>(random() % places);
    at += 0.2f * (place.row(target) - at);
    for (int d = 0; d < dimensions; ++d) states(t, d) = at[d] + 0.1f * normal(random);
  }
  return states;
}

std::vector<core::BuildInput> WanderingClips(int clips, int frames, const core::MarkerSet& set,
                                             unsigned seed, double frame_rate_hz) {
  std::vector<core::BuildInput> inputs;
  for (int c = 0; c < clips; ++c) {
    core::BuildInput& input = inputs.emplace_back();
    input.clip_id = "clip" + std::to_string(c);
    input.labels = c % 2 == 0 ? "a" : "b";
    input.states.frame_rate_hz = frame_rate_hz;
    input.states.leg_length_m = 0.9;
    input.states.states =
        WanderingStates(frames, set.dimension_count(), seed + static_cast<unsigned>(c % 2));
    // Clips of one label pass through the same places, with small differences.
    std::mt19937 random(seed + 100 + static_cast<unsigned>(c));
    std::normal_distribution<float> normal(0, 0.05f);
    for (Eigen::Index i = 0; i < input.states.states.size(); ++i) {
      input.states.states.data()[i] += normal(random);
    }
    input.states.root_path.resize(frames, 3);
    for (int t = 0; t < frames; ++t) {
      input.states.root_path.row(t) << 0.01 * t, 0.002 * t * c, 0.001 * t;
    }
  }
  return inputs;
}

core::Model SmallModel(int clips, int frames, int markers, int min_frames, unsigned seed) {
  core::BuildSettings settings;
  settings.min_frames = min_frames;
  const core::MarkerSet set = SmallMarkerSet(markers);
  auto model = core::BuildModel(settings, set, WanderingClips(clips, frames, set, seed),
                                core::RunSerially, {});
  INFO(model.status());
  REQUIRE(model.ok());
  return *std::move(model);
}

}  // namespace motiondb::tests
