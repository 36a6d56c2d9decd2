// Writes GLB files for other readers, with the positions that these must find. Runs for
// glb_three_test.sh only.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/export/writers.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/export/odd_skeleton.h"
#include "tests/core/format/reading.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests::glb_samples_test {
namespace {

// Writes NAME.glb and NAME.json, the content of which check_glb.mjs describes.
void WriteSample(const std::filesystem::path& folder, const std::string& name,
                 const core::JointMotion& motion) {
  const auto bytes = core::WriteGlb(motion);
  INFO(MessageOf(bytes.status()));
  REQUIRE(bytes.ok());
  std::ofstream(folder / (name + ".glb"), std::ios::binary) << *bytes;
  nlohmann::json frames = nlohmann::json::array();
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    nlohmann::json joints = nlohmann::json::array();
    for (const auto& pose : core::ForwardKinematics(*motion.skeleton, motion.angles.row(frame))) {
      const Eigen::Vector3d p = pose.translation();
      joints.push_back({p.x(), p.z(), -p.y()});
    }
    frames.push_back(std::move(joints));
  }
  const nlohmann::json expected = {{"frame_rate_hz", motion.frame_rate_hz}, {"positions", frames}};
  std::ofstream(folder / (name + ".json")) << expected;
}

}  // namespace

TEST_CASE("Samples of GLB for other readers", "[.samples]") {
  // Catch runs hidden tests too if only exclusions are given.
  const char* const folder = std::getenv("MOTIONDB_GLB_SAMPLES");
  if (folder == nullptr) return;
  const std::string text = WriteBvh(StickFigure{});
  WriteSample(folder, "stick", Joints(ReadText(core::FileFormat::kBvh, text)));
  WriteSample(folder, "odd", RandomMotion(OddJoints(), 25, 29.97, 3));
  WriteSample(folder, "slow", RandomMotion(OddJoints(), 5, 0.5, 1));
  WriteSample(folder, "one-frame", RandomMotion(OddJoints(), 1, 100, 1));
}

}  // namespace motiondb::tests::glb_samples_test
