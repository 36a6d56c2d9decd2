// The glitch detector on recorded motion: no findings in real motion, all findings in altered
// motion.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <sstream>

#include "core/format/marker_set_file.h"
#include "core/motion/glitches.h"
#include "core/motion/states.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::real_glitches_test {
namespace {

using core::Glitch;
using core::MarkerMotion;

// Clips whose recording has glitches, and the last frame (from 1) that they affect. CMU's BVH
// conversions begin with a pose of the skeleton, or oscillate after it; in the others a joint
// flips.
const std::map<std::string, int> kGlitched = {
    {"cmu/09/09_10.amc", 4}, {"cmu/10/10_01.bvh", 2},
    {"cmu/10/10_02.bvh", 2}, {"cmu/10/10_03.bvh", 2},
    {"cmu/10/10_04.bvh", 2}, {"cmu/10/10_05.bvh", 2},
    {"cmu/10/10_06.bvh", 2}, {"cmu/11/11_01.bvh", 2},
    {"cmu/16/16_15.amc", 2}, {"cmu/16/16_23.amc", 3},
    {"cmu/16/16_28.amc", 6}, {"hdm05/HDM_dg_lieDownFloor_014_120.amc", 254}};

// Jumps, a kick, hops and a throw.
const char* const kFast[] = {
    "cmu/02/02_04.amc", "cmu/49/49_02.amc", "hdm05/HDM_bd_kickLFront1Reps_001_120.amc",
    "hdm05/HDM_dg_hopBothLegs1hops_022_120.amc", "hdm05/HDM_bk_throwBasketball_004_120.amc"};

MarkerMotion Markers(const std::string& path) {
  auto markers = core::ApplyScheme(core::StandardScheme(), LoadMotion(DataDir() / path).motion);
  INFO(path << ": " << markers.status());
  REQUIRE(markers.ok());
  return *std::move(markers);
}

std::vector<Glitch> Find(const MarkerMotion& motion) {
  return core::FindGlitches(motion, *core::EstimateLegLength(core::StandardScheme().set, motion));
}

std::string Text(const std::vector<Glitch>& glitches, const MarkerMotion& motion) {
  std::string text;
  for (const Glitch& glitch : glitches) text += core::Describe(glitch, motion) + "; ";
  return text;
}

MarkerMotion EveryNth(const MarkerMotion& motion, int n) {
  MarkerMotion fewer{motion.names, motion.frame_rate_hz / n, {}};
  const Eigen::Index frames = (motion.positions_m.rows() + n - 1) / n;
  fewer.positions_m.resize(frames, motion.positions_m.cols());
  for (Eigen::Index f = 0; f < frames; ++f) {
    fewer.positions_m.row(f) = motion.positions_m.row(f * n);
  }
  return fewer;
}

}  // namespace

TEST_CASE("FindGlitches: finds only the known glitches of recorded clips", "[glitches][real]") {
  MOTIONDB_REQUIRE_DATA();
  std::ifstream index(DataDir() / "index.tsv");
  std::string line;
  std::getline(index, line);
  int clips = 0;
  while (std::getline(index, line)) {
    const std::string path = line.substr(0, line.find('\t'));
    const MarkerMotion motion = Markers(path);
    const auto known = kGlitched.find(path);
    const int last = known == kGlitched.end() ? 0 : known->second;
    const auto found = Find(motion);
    INFO(path << ": " << Text(found, motion));
    CHECK(std::ranges::all_of(found, [&](const Glitch& g) { return g.last_frame < last; }));
    ++clips;
  }
  CHECK(clips > 300);
}

TEST_CASE("FindGlitches: fast motion is no glitch, at any rate and with noise",
          "[glitches][real]") {
  MOTIONDB_REQUIRE_DATA();
  for (const char* path : kFast) {
    const MarkerMotion motion = Markers(path);
    for (const int n : {1, 2, 4, 12, 40}) {
      INFO(path << " at " << 120 / n << " Hz");
      const MarkerMotion fewer = EveryNth(motion, n);
      CHECK(Text(Find(fewer), motion).empty());
      for (const float noise_m : {0.01F, 0.02F, 0.05F}) {
        MarkerMotion noisy = fewer;
        std::mt19937 random(static_cast<unsigned>(n));
        std::normal_distribution<float> noise(0, noise_m);
        for (float& x : noisy.positions_m.reshaped()) x += noise(random);
        INFO("noise " << noise_m << " m");
        CHECK(Text(Find(noisy), motion).empty());
      }
    }
  }
}

TEST_CASE("FindGlitches: changes in recorded motion are found at their frames",
          "[glitches][real]") {
  MOTIONDB_REQUIRE_DATA();
  int changed = 0;
  int found_markers = 0;
  for (const char* path : kFast) {
    const MarkerMotion motion = Markers(path);
    for (const int n : {1, 2, 4}) {
      const MarkerMotion clean = EveryNth(motion, n);
      const auto frames = static_cast<int>(clean.positions_m.rows());
      for (int marker = 0; marker < std::ssize(clean.names); ++marker) {
        MarkerMotion altered = clean;
        const int frame = frames / 3 + marker % 7;
        altered.positions_m(frame, 3 * static_cast<Eigen::Index>(marker) + marker % 3) += 0.3F;
        const auto found = Find(altered);
        INFO(path << " at " << 120 / n << " Hz, " << clean.names[marker] << ", frame " << frame + 1
                  << ": " << Text(found, clean));
        // No other frame or marker.
        CHECK(std::ranges::all_of(found, [&](const Glitch& g) {
          return g.marker == marker && g.first_frame == frame && g.last_frame == frame;
        }));
        ++changed;
        found_markers += found.empty() ? 0 : 1;
      }
      MarkerMotion far = clean;
      far.positions_m.row(frames / 2).array() += 100;
      CHECK(Find(far) == std::vector<Glitch>{{Glitch::kAllMarkers, frames / 2, frames / 2}});
    }
  }
  INFO(found_markers << " of " << changed);
  CHECK(found_markers > 0.95 * changed);
}

}  // namespace motiondb::tests::real_glitches_test
