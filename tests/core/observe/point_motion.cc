#include "tests/core/observe/point_motion.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/synthetic_states.h"

namespace motiondb::tests {

core::MarkerScheme PointScheme() { return {SmallMarkerSet(6), {}}; }

core::MarkerMotion PointMotion(int frames, unsigned seed, unsigned variant, double frame_rate_hz) {
  constexpr int kMarkers = 6;
  const core::FrameMatrix wander = WanderingStates(frames, 3 * kMarkers, seed);
  std::mt19937 random(1000 * seed + variant);
  std::normal_distribution<float> noise(0, 0.004F);
  core::MarkerMotion motion{PointScheme().set.markers, frame_rate_hz,
                            core::FrameMatrix(frames, 3 * kMarkers)};
  for (int t = 0; t < frames; ++t) {
    const float heading = 0.02F * static_cast<float>(t) + static_cast<float>(variant);
    const float c = std::cos(heading);
    const float s = std::sin(heading);
    for (int m = 0; m < kMarkers; ++m) {
      Eigen::Vector3f local = 0.06F * wander.row(t).segment<3>(3 * m).transpose();
      if (m < 2) local = {0, m == 0 ? 0.1F : -0.1F, 0};  // the hips
      local.z() += 0.9F - 0.1F * static_cast<float>(m);
      motion.positions_m.row(t).segment<3>(3 * m)
          << 0.01F * static_cast<float>(t) + c * local.x() - s * local.y() + noise(random),
          s * local.x() + c * local.y() + noise(random), local.z() + noise(random);
    }
  }
  return motion;
}

core::StateSequence PointStates(const core::MarkerMotion& motion) {
  auto states = core::ComputeStates(PointScheme().set, motion, kLegLength_m);
  INFO(states.status());
  REQUIRE(states.ok());
  return *std::move(states);
}

core::Model PointModel(int labels, int clips_each, bool calibrated) {
  std::vector<core::BuildInput> inputs;
  for (int label = 0; label < labels; ++label) {
    for (int clip = 0; clip < clips_each; ++clip) {
      core::BuildInput& input = inputs.emplace_back();
      input.clip_id = "clip" + std::to_string(inputs.size());
      input.labels = std::string(1, static_cast<char>('a' + label));
      input.states =
          PointStates(PointMotion(150, static_cast<unsigned>(label), static_cast<unsigned>(clip)));
    }
  }
  core::BuildSettings settings;
  settings.min_frames = 8;
  auto model = core::BuildModel(settings, PointScheme().set, inputs, core::RunSerially, {});
  INFO(model.status());
  REQUIRE(model.ok());
  if (calibrated) {
    core::RecognitionCalibration recognition;
    for (int i = -400; i < 400; ++i) {
      recognition.window.familiarity.push_back(static_cast<float>(i) / 40);
    }
    model->set_recognition(recognition);
  }
  return *std::move(model);
}

void Hide(core::MarkerMotion& motion, int marker, Eigen::Index first, Eigen::Index end) {
  motion.positions_m.block(first, 3 * marker, end - first, 3)
      .setConstant(std::numeric_limits<float>::quiet_NaN());
}

}  // namespace motiondb::tests
