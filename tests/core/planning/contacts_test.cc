#include "core/planning/contacts.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <set>

#include "core/format/marker_set_file.h"
#include "tests/core/planning/walking_figure.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::contacts_test {
namespace {

std::set<std::string> Names(const std::vector<int>& markers, const core::MarkerSet& set) {
  std::set<std::string> names;
  for (const int m : markers) names.insert(set.markers[m]);
  return names;
}

// Returns the feet of a clip, and its own joints or markers as `set`.
core::Feet FeetOfSource(const std::filesystem::path& path, core::MarkerSet& set) {
  const core::Motion motion = LoadMotion(path).motion;
  const auto scheme = core::SourceScheme(motion);
  REQUIRE(scheme.ok());
  auto states = core::Represent(*scheme, motion, 60, core::GlitchPolicy::kRepair);
  INFO(states.status());
  REQUIRE(states.ok());
  core::BuildSettings settings;
  settings.min_frames = 100;
  set = scheme->set;
  const auto model =
      core::BuildModel(settings, set, {{"a", "a", *std::move(states)}}, core::RunSerially, {});
  REQUIRE(model.ok());
  return core::FindFeet(*model);
}

}  // namespace

TEST_CASE("FindFeet: finds the markers of a foot and their rest heights", "[core][planning]") {
  const core::MarkerSet set = WalkerSet();
  for (const core::Scaling scaling : {core::Scaling::kNone, core::Scaling::kKind}) {
    const core::Feet feet = core::FindFeet(WalkingFigure{}.Model(scaling));
    REQUIRE(feet.size() == 2);
    for (const int side : {0, 1}) {
      const core::Foot& foot = feet[side];
      CHECK(foot.leg == set.landmarks.legs[side]);
      CHECK(foot.contact_markers ==
            std::vector<int>{WalkerIndex(side, kToe), WalkerIndex(side, kHeel)});
      REQUIRE(foot.rest_heights.size() == 2);
      CHECK(foot.rest_heights[0] * WalkingFigure::kLeg_m ==
            Approx(WalkingFigure::kToeRest_m).margin(0.003));
      CHECK(foot.rest_heights[1] * WalkingFigure::kLeg_m ==
            Approx(WalkingFigure::kHeelRest_m).margin(0.003));
      CHECK(foot.foot_markers.size() == 3);
      CHECK(foot.thigh_markers == std::vector<int>{WalkerIndex(side, kThigh)});
      CHECK(foot.shin_markers == std::vector<int>{WalkerIndex(side, kShin)});
    }
  }
}

TEST_CASE("FindFeet: a set without a whole leg has no feet, without foot markers it uses ankles",
          "[core][planning]") {
  CHECK(core::FindFeet(SmallModel(2, 60, 3, 8, 1)).empty());
  const core::Feet feet = core::FindFeet(SmallModel(2, 60, 4, 8, 1));
  REQUIRE(feet.size() == 1);
  CHECK(feet[0].contact_markers == std::vector<int>{3});
  CHECK(feet[0].foot_markers == std::vector<int>{3});
  CHECK(core::DetectContacts({}, core::FrameMatrix::Zero(5, 12), 60, 1).cols() == 0);
}

TEST_CASE("DetectContacts: finds the contacts of heel and toe of a walker, at any rate",
          "[core][planning]") {
  const core::Feet feet = core::FindFeet(WalkingFigure{}.Model());
  for (const double rate : {30.0, 60.0, 120.0}) {
    for (const double floor_m : {0.0, 0.03, -0.03}) {
      const WalkingFigure figure{.rate_hz = rate, .floor_m = floor_m};
      const core::FrameMatrix positions = figure.Motion().positions_m;
      const core::ContactMatrix found =
          core::DetectContacts(feet, positions, rate, WalkingFigure::kLeg_m);
      const core::ContactMatrix truth = figure.Contacts(feet, positions.rows());
      REQUIRE(found.cols() == truth.cols());
      // Errors only near a landing or take-off, where a foot in the air is slow and low.
      const auto near = static_cast<Eigen::Index>(std::lround(0.08 * rate));
      int wrong = 0;
      for (Eigen::Index c = 0; c < truth.cols(); ++c) {
        for (Eigen::Index t = near; t + near < truth.rows(); ++t) {
          const auto around = truth.col(c).segment(t - near, 2 * near + 1);
          if (around.all() || !around.any()) wrong += found(t, c) != truth(t, c);
        }
      }
      INFO(rate << " Hz, floor at " << floor_m);
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("DetectContacts: closes short gaps, drops short runs, ignores missing markers",
          "[core][planning]") {
  core::Foot foot;
  foot.leg = {0, 0, 0};
  foot.contact_markers = {0};
  foot.rest_heights = {0.04f};
  core::FrameMatrix positions = core::FrameMatrix::Zero(120, 3);
  positions.col(2).setConstant(0.04f);
  const auto contacts = [&] {
    return core::DetectContacts({foot}, positions, 60, 1).col(0).cast<int>().sum();
  };
  CHECK(contacts() == 120);
  positions(50, 2) = 0.2f;  // one raised frame, and two with speed
  CHECK(contacts() == 117);
  for (int t = 0; t < 120; ++t) positions(t, 2) = t >= 50 && t < 53 ? 0.04f : 0.5f;
  CHECK(contacts() == 0);
  for (int t = 0; t < 120; ++t) positions(t, 0) = 0.7f * static_cast<float>(t) / 60;
  positions.col(2).setConstant(0.04f);
  CHECK(contacts() == 0);  // low, but not slow
  positions.setConstant(std::nanf(""));
  CHECK(contacts() == 0);
}

TEST_CASE("DetectContacts: recorded walking", "[core][planning][data]") {
  MOTIONDB_REQUIRE_DATA();
  for (const double rate : {30.0, 60.0, 120.0}) {
    core::BuildSettings settings;
    settings.frame_rate_hz = rate;
    settings.min_frames = 10000;  // a small tree is enough
    const core::Model model = BuildFromList(DataDir() / "sets" / "database2.tsv", settings);
    const core::Feet feet = core::FindFeet(model);
    REQUIRE(feet.size() == 2);
    CHECK(Names(feet[0].contact_markers, model.marker_set()) ==
          std::set<std::string>{"LHeel", "LToe"});
    CHECK(Names(feet[1].contact_markers, model.marker_set()) ==
          std::set<std::string>{"RHeel", "RToe"});
    CHECK(Names(feet[0].thigh_markers, model.marker_set()) == std::set<std::string>{"LThigh"});
    CHECK(Names(feet[0].shin_markers, model.marker_set()) == std::set<std::string>{"LShin"});
    std::vector<double> duties;
    for (const char* name : {"16_11", "16_12", "16_14", "16_15", "16_16", "16_17", "16_31", "16_32",
                             "16_33", "16_34", "16_58"}) {  // no running
      const auto states = LoadStates(DataDir() / "cmu/16" / (std::string(name) + ".amc"), rate);
      const core::ContactMatrix contacts =
          core::DetectContacts(feet, core::WorldPositions(states), rate, states.leg_length_m);
      const auto left = contacts.leftCols(2).rowwise().any();
      const auto right = contacts.rightCols(2).rowwise().any();
      INFO(name << " at " << rate << " Hz");
      const auto frames = static_cast<double>(contacts.rows());
      duties.push_back(static_cast<double>(left.count()) / frames);
      duties.push_back(static_cast<double>(right.count()) / frames);
      CHECK((duties.back() > 0.5 && duties.back() < 0.8));
      CHECK(static_cast<double>((!left && !right).count()) <= 0.01 * frames);
      // Feet alternate: between two landings of one foot there is one of the other.
      int last = -1;
      int repeats = 0;
      // A run at either end may be incomplete.
      const Eigen::Index end = std::lround(0.1 * rate);
      for (Eigen::Index t = end; t < contacts.rows() - end; ++t) {
        for (const int side : {0, 1}) {
          const auto columns = contacts.middleCols(2 * side, 2);
          if (columns.row(t).any() && !columns.row(t - 1).any()) {
            repeats += side == last;
            last = side;
          }
        }
      }
      CHECK(repeats == 0);
    }
    std::sort(duties.begin(), duties.end());
    std::printf("%3.0f Hz: duty factor %.2f to %.2f, median %.2f\n", rate, duties.front(),
                duties.back(), duties[duties.size() / 2]);
  }
}

TEST_CASE("FindFeet: sets of a source's own joints or markers", "[core][planning][data]") {
  MOTIONDB_REQUIRE_DATA();
  core::MarkerSet set;
  const core::Feet joints = FeetOfSource(DataDir() / "cmu/02/02_01.amc", set);
  REQUIRE(joints.size() == 2);
  CHECK(Names(joints[0].contact_markers, set) == std::set<std::string>{"ltoes"});
  CHECK(Names(joints[1].contact_markers, set) == std::set<std::string>{"rtoes"});
  const core::Feet optical = FeetOfSource(DataDir() / "formats/same-motion/02_01.c3d", set);
  REQUIRE(optical.size() == 2);
  for (const core::Foot& foot : optical) {
    std::string found;
    for (const std::string& name : Names(foot.contact_markers, set)) found += name + " ";
    for (const std::string& name : Names(foot.shin_markers, set)) found += "shin " + name + " ";
    for (const std::string& name : Names(foot.thigh_markers, set)) found += "thigh " + name + " ";
    INFO(found);
    CHECK(foot.contact_markers.size() >= 2);
    CHECK(foot.contact_markers.size() <= 4);
    std::printf("optical: %s\n", found.c_str());
  }
}

}  // namespace motiondb::tests::contacts_test
