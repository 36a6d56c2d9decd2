#include "core/format/plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/format/conventions.h"
#include "core/format/marker_set_file.h"

namespace motiondb::tests::plausibility_test {
namespace {

using Catch::Contains;
using core::UpAxis;
using Eigen::Vector3d;

const Vector3d kX = Vector3d::UnitX();
const Vector3d kY = Vector3d::UnitY();
const Vector3d kZ = Vector3d::UnitZ();

// Returns the message of a refusal; empty: it was accepted.
std::string RefusalOf(const absl::Status& status) {
  if (status.ok()) return "";
  CHECK(absl::IsInvalidArgument(status));
  CHECK_THAT(std::string(status.message()), Contains("set force (--force)"));
  return std::string(status.message());
}

// Directions of a body: from pelvis to neck, and from ankles to hips.
struct Body {
  Vector3d trunk;
  Vector3d legs;
};

const Body kStanding{kZ, kZ};
const Body kLying{kX, kX};
const Body kUnknown{kX * NAN, kX};

// Returns the states of a motion with these bodies, in the axes of a file that is read with `up`.
// In the world, the bodies face to 2 rad.
core::StateSequence StatesOf(const core::MarkerSet& set, const std::vector<Body>& bodies,
                             UpAxis up = UpAxis::kZ) {
  constexpr double kHeading = 2;
  const Eigen::Matrix3d state_from_file =
      Eigen::AngleAxisd(-kHeading, kZ).toRotationMatrix() * core::WorldFromFile(up);
  const auto frames = static_cast<Eigen::Index>(bodies.size());
  core::StateSequence states{60, 0.85, {}, core::RootPath::Zero(frames, 3)};
  states.root_path.col(2).setConstant(kHeading);
  states.states.setConstant(frames, set.dimension_count(), std::nanf(""));
  for (Eigen::Index t = 0; t < frames; ++t) {
    const auto put = [&](const std::string& marker, const Vector3d& at) {
      const auto index = std::ranges::find(set.markers, marker) - set.markers.begin();
      if (index == std::ssize(set.markers)) return;
      states.states.row(t).segment<3>(6 * index) = (state_from_file * at).transpose().cast<float>();
    };
    const Body& body = bodies[static_cast<std::size_t>(t)];
    put("Pelvis", Vector3d::Zero());
    put("Neck", 0.6 * body.trunk);
    put("LHip", 0.1 * kY);
    put("RHip", -0.1 * kY);
    put("LAnkle", 0.1 * kY - body.legs);
    put("RAnkle", -0.1 * kY - body.legs);
  }
  return states;
}

core::MarkerSet StandardSet() { return core::StandardScheme().set; }

std::string PostureRefusal(const std::vector<Body>& bodies, UpAxis up = UpAxis::kZ,
                           const core::MarkerSet& set = StandardSet()) {
  core::SourceReport report;
  report.up_axis = up;
  return RefusalOf(core::CheckPosture(set, StatesOf(set, bodies, up), report));
}

absl::Status CheckLeg(double leg_length_m, const core::SourceReport& report) {
  return core::CheckMeasuredLeg(leg_length_m, report);
}

// Returns `count` frames with a body, then `others` with another.
std::vector<Body> Frames(int count, const Body& body, int others, const Body& other) {
  std::vector<Body> frames(static_cast<std::size_t>(count), body);
  frames.insert(frames.end(), static_cast<std::size_t>(others), other);
  return frames;
}

}  // namespace

TEST_CASE("CheckBodySize: the error suggests the unit in which the legs are a person's",
          "[core][format]") {
  struct Case {
    double leg_units;
    double metres_per_unit;
    std::string expected;  // in the message; empty: accepted
  };
  const std::vector<Case> cases = {
      {0.85, 1, ""},
      {0.3, 1, ""},
      {1.5, 1, ""},
      {85, 0.01, ""},
      {15, 0.0254 / 0.45, ""},
      {0.29, 1, "check the unit"},
      {1.51, 1, "check the unit"},
      {85, 1, "the unit is probably cm: set metres_per_unit 0.01 (--metres-per-unit 0.01)"},
      {85, 0.001, "set metres_per_unit 0.01 ("},
      {850, 0.01, "the unit is probably mm: set metres_per_unit 0.001 ("},
      {0.85, 0.01, "the unit is probably m: set metres_per_unit 1 ("},
      {33.5, 1, "the unit is probably inch: set metres_per_unit 0.0254 ("},
      {15, 0.01, "the unit is probably CMU's unit: set metres_per_unit 0.05644 ("},
      {5, 1, "check the unit"},
  };
  for (const auto& [leg_units, metres_per_unit, expected] : cases) {
    CAPTURE(leg_units, metres_per_unit);
    core::SourceReport report;
    report.metres_per_unit = metres_per_unit;
    const std::string refusal = RefusalOf(CheckLeg(leg_units * metres_per_unit, report));
    CHECK(refusal.empty() == expected.empty());
    CHECK_THAT(refusal, Contains(expected));
  }
}

TEST_CASE("CheckBodySize: the error has the length, the unit and the limits", "[core][format]") {
  core::SourceReport report;
  report.metres_per_unit = 0.02;
  CHECK_THAT(RefusalOf(CheckLeg(1.64, report)),
             Contains("the legs would be 1.64 m long with 0.02 m per unit; expected 0.3 to 1.5 m"));
}

TEST_CASE("CheckBodySize: a given leg length does not hide a wrong unit", "[core][format]") {
  const core::MarkerSet set = StandardSet();
  core::StateSequence states{60, 0.85, {}, core::RootPath::Zero(1, 3)};
  states.states.setConstant(1, set.dimension_count(), 0);
  const auto put_down = [&](const std::string& marker, float legs) {
    const auto index = std::ranges::find(set.markers, marker) - set.markers.begin();
    states.states(0, 6 * index + 2) = -legs;
  };
  for (const char* side : {"L", "R"}) {
    put_down(std::string(side) + "Knee", 0.5F);
    put_down(std::string(side) + "Ankle", 1);
  }
  CHECK(core::CheckBodySize(set, states, {}).ok());
  states.states *= 100;  // read in metres, but the file is in centimetres
  CHECK_THAT(RefusalOf(core::CheckBodySize(set, states, {})),
             Contains("85 m long") && Contains("--metres-per-unit 0.01"));
  // Without a whole leg, the leg length is an estimate from other markers.
  put_down("LKnee", NAN);
  put_down("RKnee", NAN);
  CHECK(core::CheckBodySize(set, states, {}).ok());
}

TEST_CASE("CheckGivenLegLength: the error converts the length from the probable unit",
          "[core][format]") {
  for (const double leg_m : {0.3, 0.85, 1.5}) CHECK(core::CheckGivenLegLength(leg_m).ok());
  const std::vector<std::pair<double, std::string>> cases = {
      {85, "got 85; 85 cm are 0.85 m"}, {850, "850 mm are 0.85 m"},
      {33.5, "33.5 inch are 0.8509 m"}, {1.51, "check the number"},
      {0.29, "check the number"},       {5, "check the number"},
      {NAN, "check the number"},        {INFINITY, "check the number"}};
  for (const auto& [leg_m, expected] : cases) {
    CAPTURE(leg_m);
    CHECK_THAT(RefusalOf(core::CheckGivenLegLength(leg_m)),
               Contains("expected 0.3 to 1.5 m for a person") && Contains(expected));
  }
}

TEST_CASE("CheckPosture: a body is upright if its trunk or its legs are", "[core][format]") {
  const auto leaning = [](double degrees) -> Vector3d {
    const double angle = degrees * M_PI / 180;
    return {std::cos(angle), 0, std::sin(angle)};
  };
  struct Case {
    std::string posture;
    Body body;
    bool is_accepted;
  };
  const std::vector<Case> cases = {
      {"standing", kStanding, true},
      {"sitting, legs to the front", {kZ, -kX}, true},
      {"bending, trunk horizontal", {kX, kZ}, true},
      {"bending, head at the knees", {-kZ, kZ}, true},
      {"on all fours, shins on the floor", {kX, (kX + kZ).normalized()}, true},
      {"lying on the back", {-kX, -kX}, false},
      {"lying, legs to one side", {kX, kY}, false},
      {"lying, legs up", {kX, -kZ}, false},
      {"upside down", {-kZ, -kZ}, false},
      {"trunk 31 degrees above the floor", {leaning(31), kX}, true},
      {"trunk 29 degrees above the floor", {leaning(29), kX}, false},
      {"legs 31 degrees above the floor", {kX, leaning(31)}, true},
      {"legs 29 degrees above the floor", {kX, leaning(29)}, false},
  };
  for (const auto& [posture, body, is_accepted] : cases) {
    CAPTURE(posture);
    CHECK(PostureRefusal({10, body}).empty() == is_accepted);
  }
}

TEST_CASE("CheckPosture: the error suggests the axis that points up", "[core][format]") {
  struct Axis {
    std::string name;
    UpAxis up;
    Vector3d direction;
  };
  const std::vector<Axis> axes = {{"x", UpAxis::kX, kX},        {"y", UpAxis::kY, kY},
                                  {"z", UpAxis::kZ, kZ},        {"-x", UpAxis::kMinusX, -kX},
                                  {"-y", UpAxis::kMinusY, -kY}, {"-z", UpAxis::kMinusZ, -kZ}};
  for (const Axis& real : axes) {
    for (const Axis& read : axes) {
      CAPTURE(real.name, read.name);
      const std::string refusal =
          PostureRefusal({10, Body{real.direction, real.direction}}, read.up);
      if (real.name == read.name) {
        CHECK(refusal.empty());
        continue;
      }
      CHECK_THAT(refusal, Contains(fmt::format("its head along {} of the file, with {} up",
                                               real.name, read.name)));
      // No setting names a negative axis.
      const bool can_be_set = real.name.size() == 1;
      CHECK_THAT(refusal,
                 Contains(can_be_set ? fmt::format("set up_axis {0} (--up-axis {0})", real.name)
                                     : std::string("check the axes")));
      CHECK((refusal.find("set up_axis") != std::string::npos) == can_be_set);
    }
  }
}

TEST_CASE("CheckPosture: 95 % of the frames decide, without those with missing markers",
          "[core][format]") {
  CHECK(PostureRefusal(Frames(96, kLying, 4, kStanding)) != "");
  CHECK(PostureRefusal(Frames(94, kLying, 6, kStanding)) == "");
  CHECK(PostureRefusal(Frames(90, kUnknown, 10, kLying)) != "");
  CHECK(PostureRefusal(Frames(98, kUnknown, 2, kStanding)) == "");
  CHECK(PostureRefusal({10, kUnknown}) == "");
  CHECK(PostureRefusal({10, Body{kX, kX * NAN}}) == "");
  CHECK(PostureRefusal({}) == "");
}

TEST_CASE("CheckPosture: a set without pelvis, neck or legs is not checked", "[core][format]") {
  for (const char* const missing : {"Pelvis", "Neck"}) {
    core::MarkerSet set = StandardSet();
    *std::ranges::find(set.markers, missing) = "other";
    CHECK(PostureRefusal({10, kLying}, UpAxis::kZ, set) == "");
  }
  core::MarkerSet without_legs = StandardSet();
  without_legs.landmarks.legs.clear();
  CHECK(PostureRefusal({10, kLying}, UpAxis::kZ, without_legs) == "");
  // With one leg it is.
  core::MarkerSet with_one_leg = StandardSet();
  with_one_leg.landmarks.legs.pop_back();
  CHECK(PostureRefusal({10, kLying}, UpAxis::kZ, with_one_leg) != "");
  CHECK(PostureRefusal({10, kStanding}, UpAxis::kZ, with_one_leg) == "");
}

}  // namespace motiondb::tests::plausibility_test
