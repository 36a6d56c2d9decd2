#include "core/motion/glitches.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace motiondb::tests::glitches_test {
namespace {

using core::Glitch;
using core::GlitchKind;
using core::MarkerMotion;

constexpr double kLeg_m = 0.85;
enum {
  kLeftHip,
  kRightHip,
  kChest,
  kShoulder,
  kElbow,
  kForearm,
  kWrist,
  kHand,
  kKnee,
  kAnkle,
  kHeel,
  kToe
};
const std::vector<std::string> kNames = {"LHip",  "RHip", "Chest", "Shoulder", "Elbow", "Forearm",
                                         "Wrist", "Hand", "Knee",  "Ankle",    "Heel",  "Toe"};

// A body that jogs at 3 m/s along x and swings an arm and a leg with constant link lengths. It may
// stand still first; then it starts smoothly.
MarkerMotion Jog(double rate_hz, double seconds, double noise_m = 0, double still_seconds = 0) {
  const auto frames = static_cast<Eigen::Index>(seconds * rate_hz);
  MarkerMotion motion{kNames, rate_hz, core::FrameMatrix(frames, 3 * std::ssize(kNames))};
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, noise_m > 0 ? noise_m : 1);
  for (Eigen::Index f = 0; f < frames; ++f) {
    const double u = std::max(0.0, static_cast<double>(f) / rate_hz - still_seconds);
    const double t = still_seconds > 0 ? u * u / (1 + u) : u;
    const double swing = 1.1 * std::sin(2 * std::numbers::pi * 1.4 * t);
    const double bend = 0.8 + 0.6 * std::sin(2 * std::numbers::pi * 1.4 * t + 1);
    const Eigen::Vector3d root(3 * t + 1, 2,
                               0.95 + 0.04 * std::sin(2 * std::numbers::pi * 2.8 * t));
    const auto along = [](double angle, double length) {
      return Eigen::Vector3d(length * std::sin(angle), 0, -length * std::cos(angle));
    };
    std::vector<Eigen::Vector3d> at(kNames.size());
    at[kLeftHip] = root + Eigen::Vector3d(0, 0.1, 0);
    at[kRightHip] = root - Eigen::Vector3d(0, 0.1, 0);
    at[kChest] = root + Eigen::Vector3d(0.1, 0, 0.4);
    at[kShoulder] = root + Eigen::Vector3d(0, -0.2, 0.5);
    at[kElbow] = at[kShoulder] + along(swing, 0.3);
    at[kForearm] = at[kElbow] + along(swing + bend, 0.18);
    at[kWrist] = at[kElbow] + along(swing + bend, 0.25);
    at[kHand] = at[kElbow] + along(swing + bend, 0.33) + Eigen::Vector3d(0, 0.04, 0);
    at[kKnee] = at[kLeftHip] + along(-0.6 * swing, 0.43);
    at[kAnkle] = at[kKnee] + along(-0.6 * swing - bend, 0.42);
    at[kHeel] = at[kAnkle] + along(-0.6 * swing - bend - 0.7, 0.08);
    at[kToe] = at[kAnkle] + along(-0.6 * swing - bend + 1.2, 0.16);
    for (Eigen::Index m = 0; m < std::ssize(kNames); ++m) {
      Eigen::Vector3d p = at[static_cast<std::size_t>(m)];
      if (noise_m > 0) p += Eigen::Vector3d(noise(random), noise(random), noise(random));
      motion.positions_m.row(f).segment<3>(3 * m) = p.cast<float>().transpose();
    }
  }
  return motion;
}

auto Place(MarkerMotion& motion, int frame, int marker) {
  return motion.positions_m.row(frame).segment<3>(3 * static_cast<Eigen::Index>(marker));
}

std::vector<Glitch> Find(const MarkerMotion& motion) { return core::FindGlitches(motion, kLeg_m); }

std::string Text(const std::vector<Glitch>& glitches) {
  MarkerMotion named;
  named.names = {kNames.begin(), kNames.end()};
  std::string text;
  for (const Glitch& glitch : glitches) text += core::Describe(glitch, named) + "\n";
  return text;
}

}  // namespace

TEST_CASE("FindGlitches: finds nothing in natural motion, at any rate, with and without noise",
          "[motion][glitches]") {
  for (const double rate : {1.0, 2.0, 5.0, 10.0, 25.0, 30.0, 60.0, 120.0, 250.0, 1000.0}) {
    for (const double noise : {0.0, 0.01, 0.03, 0.05}) {
      INFO(rate << " Hz, noise " << noise << " m");
      CHECK(Text(Find(Jog(rate, std::max(4.0, 30 / rate), noise))).empty());
    }
  }
}

TEST_CASE("FindGlitches: one frame far away is found at every rate, in exactly that frame",
          "[motion][glitches]") {
  for (const double rate : {10.0, 30.0, 60.0, 120.0, 1000.0}) {
    INFO(rate << " Hz");
    MarkerMotion motion = Jog(rate, 4);
    const int frame = static_cast<int>(2 * rate);
    motion.positions_m.row(frame).array() += 100;
    CHECK(Find(motion) == std::vector<Glitch>{{Glitch::kAllMarkers, frame, frame}});
    for (const int edge : {0, static_cast<int>(motion.positions_m.rows()) - 1}) {
      MarkerMotion at_edge = Jog(rate, 4);
      at_edge.positions_m.row(edge).array() += 100;
      CHECK(Find(at_edge) == std::vector<Glitch>{{Glitch::kAllMarkers, edge, edge}});
    }
  }
}

TEST_CASE("FindGlitches: one marker 0.3 m away, in any direction, for one or many frames",
          "[motion][glitches]") {
  for (const double rate : {30.0, 60.0, 120.0}) {
    for (const int marker : {int{kHand}, int{kAnkle}, int{kHeel}}) {
      for (const int axis : {0, 1, 2}) {
        for (const int count : {1, 5}) {
          INFO(rate << " Hz, " << kNames[marker] << ", axis " << axis << ", " << count);
          MarkerMotion motion = Jog(rate, 4);
          const int first = static_cast<int>(2 * rate);
          for (int f = first; f < first + count; ++f) Place(motion, f, marker)[axis] += 0.3F;
          const auto found = Find(motion);
          INFO(Text(found));
          REQUIRE(found.size() == 1);
          CHECK(found[0].marker == marker);
          CHECK(found[0].first_frame == first);
          CHECK(found[0].last_frame == first + count - 1);
        }
      }
    }
  }
}

TEST_CASE("FindGlitches: two swapped markers are reported together", "[motion][glitches]") {
  for (const double rate : {30.0, 60.0, 120.0}) {
    INFO(rate << " Hz");
    MarkerMotion motion = Jog(rate, 4);
    const int first = static_cast<int>(2 * rate);
    for (int f = first; f < first + 6; ++f) {
      const Eigen::RowVector3f knee = Place(motion, f, kKnee);
      Place(motion, f, kKnee) = Place(motion, f, kElbow);
      Place(motion, f, kElbow) = knee;
    }
    INFO(Text(Find(motion)));
    CHECK(Find(motion) ==
          std::vector<Glitch>{{kElbow, first, first + 5, GlitchKind::kSwapped, kKnee},
                              {kKnee, first, first + 5, GlitchKind::kSwapped, kElbow}});
  }
}

TEST_CASE("FindGlitches: a marker at the origin, in some or most frames", "[motion][glitches]") {
  for (const double rate : {30.0, 60.0, 120.0}) {
    for (const double share : {0.05, 0.6}) {
      INFO(rate << " Hz, " << share);
      MarkerMotion motion = Jog(rate, 4);
      const int first = static_cast<int>(rate);
      const int last = first + static_cast<int>(share * 4 * rate);
      for (int f = first; f <= last; ++f) Place(motion, f, kHand).setZero();
      CHECK(Find(motion) == std::vector<Glitch>{{kHand, first, last, GlitchKind::kOrigin}});
    }
  }
  MarkerMotion fixed = Jog(60, 4);
  for (int f = 0; f < fixed.positions_m.rows(); ++f) Place(fixed, f, kChest).setZero();
  CHECK(Find(fixed).empty());  // a root at rest: its path was removed
}

TEST_CASE("FindGlitches: a frozen marker, or all markers, for 0.5 s while the body moves",
          "[motion][glitches]") {
  for (const double rate : {30.0, 60.0, 120.0}) {
    INFO(rate << " Hz");
    const int first = static_cast<int>(2 * rate);
    const int last = first + static_cast<int>(rate / 2);
    MarkerMotion motion = Jog(rate, 4);
    for (int f = first + 1; f <= last; ++f) Place(motion, f, kAnkle) = Place(motion, first, kAnkle);
    CHECK(Find(motion) == std::vector<Glitch>{{kAnkle, first, last, GlitchKind::kFrozen}});
    MarkerMotion all = Jog(rate, 4);
    for (int f = first + 1; f <= last; ++f) all.positions_m.row(f) = all.positions_m.row(first);
    CHECK(Find(all) ==
          std::vector<Glitch>{{Glitch::kAllMarkers, first, last, GlitchKind::kFrozen}});
  }
}

TEST_CASE("FindGlitches: a body that stops and starts by itself is no glitch",
          "[motion][glitches]") {
  for (const double rate : {10.0, 30.0, 60.0, 120.0}) {
    INFO(rate << " Hz");
    CHECK(Text(Find(Jog(rate, 4, 0, 1))).empty());
  }
}

TEST_CASE("FindGlitches: missing positions are no glitch, huge ones are", "[motion][glitches]") {
  MarkerMotion motion = Jog(60, 4);
  for (int f = 50; f < 90; ++f) {
    Place(motion, f, kWrist).setConstant(std::numeric_limits<float>::quiet_NaN());
  }
  CHECK(Find(motion).empty());
  for (const float huge : {1e6F, 1e30F, std::numeric_limits<float>::max()}) {
    MarkerMotion beyond = motion;
    Place(beyond, 120, kHand)[1] = huge;
    CHECK(Find(beyond) == std::vector<Glitch>{{kHand, 120, 120, GlitchKind::kBeyond}});
    beyond.positions_m.row(120).setConstant(huge);
    CHECK(Find(beyond) ==
          std::vector<Glitch>{{Glitch::kAllMarkers, 120, 120, GlitchKind::kBeyond}});
  }
}

TEST_CASE("FindGlitches: scales with leg length", "[motion][glitches]") {
  MarkerMotion motion = Jog(60, 4);
  Place(motion, 100, kHand)[0] += 0.3F;
  const auto found = Find(motion);
  for (const double size : {0.05, 0.5, 3.0}) {
    MarkerMotion sized = motion;
    sized.positions_m *= static_cast<float>(size);
    CHECK(core::FindGlitches(sized, size * kLeg_m) == found);
  }
}

TEST_CASE("FindGlitches: very short motions, and one without markers", "[motion][glitches]") {
  for (const int frames : {0, 1, 2, 3, 4}) {
    MarkerMotion motion = Jog(60, 4);
    motion.positions_m = motion.positions_m.topRows(frames).eval();
    CHECK(Find(motion).empty());
  }
  CHECK(Find({{}, 60, core::FrameMatrix(10, 0)}).empty());
}

}  // namespace motiondb::tests::glitches_test
