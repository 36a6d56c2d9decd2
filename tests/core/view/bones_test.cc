#include <catch2/catch.hpp>
#include <set>

#include "core/model/model.h"
#include "core/view/clip_picture.h"
#include "tests/core/planning/walking_figure.h"

namespace motiondb::tests::bones_test {
namespace {

// Bones of the walker as pairs of names, in either order.
std::set<std::set<std::string>> NamedBones(const std::vector<core::BoneEnds>& bones) {
  const core::MarkerSet set = WalkerSet();
  std::set<std::set<std::string>> named;
  for (const auto& [from, to] : bones) named.insert({set.markers[from], set.markers[to]});
  return named;
}

TEST_CASE("MarkerBones: the legs of a walker", "[core][view]") {
  const core::Model model = WalkingFigure{}.Model();
  auto states = core::ComputeStates(WalkerSet(), WalkingFigure{}.Motion());
  REQUIRE(states.ok());
  for (const auto& bones : {core::MarkerBones(model), core::MarkerBones(WalkerSet(), *states)}) {
    CHECK(bones.size() == WalkerSet().markers.size() - 1);
    const auto named = NamedBones(bones);
    for (const std::string side : {"L", "R"}) {
      for (const auto& [from, to] :
           std::vector<std::pair<std::string, std::string>>{{"Hip", "Thigh"},
                                                            {"Thigh", "Knee"},
                                                            {"Knee", "Shin"},
                                                            {"Shin", "Ankle"},
                                                            {"Ankle", "Heel"}}) {
        INFO(side << from << "-" << to);
        CHECK(named.contains({side + from, side + to}));
      }
    }
    CHECK(named.contains({"LHip", "RHip"}));
    // From the left hip outward: each bone begins at a point that was reached before.
    std::set<int> reached = {WalkerSet().landmarks.left_hip};
    for (const auto& [from, to] : bones) {
      CHECK(reached.contains(from));
      CHECK(reached.insert(to).second);
    }
  }
}

core::Skeleton Chain() {
  const auto joint = [](const char* name, int parent) {
    return core::Joint{.name = name, .parent = parent, .offset_m = {0, 0, 0.1}};
  };
  auto skeleton =
      core::Skeleton::Create("chain", {joint("root", -1), joint("hip", 0), joint("roll", 1),
                                       joint("knee", 2), joint("spine", 0), joint("hand", 4)});
  REQUIRE(skeleton.ok());
  return *std::move(skeleton);
}

TEST_CASE("MarkerBonesOf: markers that are joints have the skeleton's tree", "[core][view]") {
  const core::Skeleton skeleton = Chain();
  using Bones = std::vector<core::BoneEnds>;
  CHECK(core::JointBones(skeleton) == Bones{{0, 1}, {1, 2}, {2, 3}, {0, 4}, {4, 5}});
  core::MarkerSet all;
  all.markers = {"root", "hip", "roll", "knee", "spine", "hand"};
  CHECK(core::MarkerBonesOf(all, skeleton) == core::JointBones(skeleton));
  core::MarkerSet some;
  some.markers = {"hand", "knee", "hip", "root"};
  CHECK(core::MarkerBonesOf(some, skeleton) == Bones{{3, 2}, {2, 1}, {3, 0}});
  some.markers.push_back("LKNE");
  CHECK(core::MarkerBonesOf(some, skeleton).empty());
}

}  // namespace
}  // namespace motiondb::tests::bones_test
