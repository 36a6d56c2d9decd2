#include "import/npz/smpl_body.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace motiondb::tests::smpl_body_test {
namespace {

using importer::SmplJoint;
using importer::SmplJoints;
using importer::SmplModel;

constexpr SmplModel kModels[] = {SmplModel::kSmpl, SmplModel::kSmplH, SmplModel::kSmplX};

const SmplJoint& Named(const std::vector<SmplJoint>& joints, std::string_view name) {
  const auto found = std::ranges::find(joints, name, &SmplJoint::name);
  REQUIRE(found != joints.end());
  return *found;
}

}  // namespace

TEST_CASE("SmplJoints: published order and parents", "[import]") {
  const std::vector<int> parents = {-1, 0, 0, 0,  1,  2,  3,  4,  5,  6,  7,  8,
                                    9,  9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21};
  const std::vector<SmplJoint> smpl = SmplJoints(SmplModel::kSmpl);
  REQUIRE(smpl.size() == 24);
  for (std::size_t j = 0; j < smpl.size(); ++j) CHECK(smpl[j].parent == parents[j]);

  const auto check = [](SmplModel model, std::size_t index, std::string_view name, int parent) {
    const std::vector<SmplJoint> joints = SmplJoints(model);
    CAPTURE(importer::NameOf(model), index);
    REQUIRE(index < joints.size());
    CHECK(joints[index].name == name);
    CHECK(joints[index].parent == parent);
  };
  for (const SmplModel model : kModels) {
    check(model, 0, "pelvis", -1);
    check(model, 1, "left_hip", 0);
    check(model, 8, "right_ankle", 5);
    check(model, 15, "head", 12);
    check(model, 20, "left_wrist", 18);
  }
  CHECK(SmplJoints(SmplModel::kSmplH).size() == 52);
  check(SmplModel::kSmplH, 22, "left_index1", 20);
  check(SmplModel::kSmplH, 25, "left_middle1", 20);
  check(SmplModel::kSmplH, 28, "left_pinky1", 20);
  check(SmplModel::kSmplH, 31, "left_ring1", 20);
  check(SmplModel::kSmplH, 36, "left_thumb3", 35);
  check(SmplModel::kSmplH, 37, "right_index1", 21);
  check(SmplModel::kSmplH, 51, "right_thumb3", 50);
  CHECK(SmplJoints(SmplModel::kSmplX).size() == 55);
  check(SmplModel::kSmplX, 22, "jaw", 15);
  check(SmplModel::kSmplX, 23, "left_eye_smplhf", 15);
  check(SmplModel::kSmplX, 25, "left_index1", 20);
  check(SmplModel::kSmplX, 40, "right_index1", 21);
  check(SmplModel::kSmplX, 54, "right_thumb3", 53);
}

TEST_CASE("SmplJoints: the T-pose is symmetric, with left at positive x", "[import]") {
  for (const SmplModel model : kModels) {
    const std::vector<SmplJoint> joints = SmplJoints(model);
    std::set<std::string_view> names;
    for (const SmplJoint& joint : joints) {
      CAPTURE(importer::NameOf(model), joint.name);
      CHECK(names.insert(joint.name).second);
      if (joint.name.starts_with("left_")) {
        const SmplJoint& other = Named(joints, "right_" + std::string(joint.name.substr(5)));
        CHECK(joint.rest.x() > 0);
        CHECK((joint.rest - Eigen::Vector3d(-1, 1, 1).cwiseProduct(other.rest)).norm() < 1e-12);
      } else if (!joint.name.starts_with("right_")) {
        CHECK(joint.rest.x() == 0);
      }
    }
  }
}

TEST_CASE("SmplJoints: segments have the published lengths", "[import]") {
  const std::vector<SmplJoint> joints = SmplJoints(SmplModel::kSmpl);
  const auto length = [&](std::string_view a, std::string_view b) {
    return (Named(joints, a).rest - Named(joints, b).rest).norm();
  };
  CHECK(length("left_hip", "left_knee") == Approx(0.245));
  CHECK(length("left_knee", "left_ankle") == Approx(0.246));
  CHECK(length("left_shoulder", "left_elbow") == Approx(0.186));
  CHECK(length("left_elbow", "left_wrist") == Approx(0.146));
  CHECK(Named(joints, "left_foot").rest.z() > Named(joints, "left_ankle").rest.z());
  CHECK(Named(joints, "left_foot").rest.y() > 0);
}

}  // namespace motiondb::tests::smpl_body_test
