// Tables are parsed as robot code does; the robot's pose must be preserved.
#include <algorithm>
#include <catch2/catch.hpp>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>

#include "core/export/writers.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::joint_table_writer_test {
namespace {

using Catch::Contains;
using core::Dof;
using core::Joint;
using core::JointMotion;
using core::MimicJoint;
using Eigen::Vector3d;

struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;

  double At(std::size_t row, std::string_view column) const {
    const auto at = std::find(columns.begin(), columns.end(), column);
    REQUIRE(at != columns.end());
    return rows.at(row).at(static_cast<std::size_t>(at - columns.begin()));
  }
};

// RFC 4180, with LF line ends.
Table Parse(std::string_view text) {
  std::vector<std::vector<std::string>> lines(1, std::vector<std::string>(1));
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string& field = lines.back().back();
    if (quoted) {
      if (text[i] != '"') {
        field += text[i];
      } else if (text.substr(i + 1).starts_with('"')) {
        field += text[i++];
      } else {
        quoted = false;
      }
    } else if (text[i] == '"') {
      quoted = true;
    } else if (text[i] == ',') {
      lines.back().emplace_back();
    } else if (text[i] == '\n') {
      lines.emplace_back(1);
    } else {
      field += text[i];
    }
  }
  REQUIRE(lines.back() == std::vector<std::string>(1));  // the text ends with a line end
  lines.pop_back();
  Table table{.columns = lines.at(0), .rows = {}};
  for (std::size_t line = 1; line < lines.size(); ++line) {
    REQUIRE(lines[line].size() == table.columns.size());
    std::vector<double>& row = table.rows.emplace_back();
    for (const std::string& field : lines[line]) {
      const char* end = field.data() + field.size();
      REQUIRE(std::from_chars(field.data(), end, row.emplace_back()).ptr == end);
    }
  }
  return table;
}

Table WriteAndParse(const JointMotion& motion, std::span<const MimicJoint> mimics = {}) {
  const auto text = core::WriteJointTable(motion, mimics);
  INFO(MessageOf(text.status()));
  REQUIRE(text.ok());
  return Parse(*text);
}

std::vector<Dof> FreeDofs() {
  std::vector<Dof> dofs;
  for (int axis : {0, 1, 2}) {
    dofs.push_back({.kind = Dof::Kind::kTranslation, .axis = Vector3d::Unit(axis)});
  }
  for (int axis : {2, 1, 0}) dofs.push_back({.axis = Vector3d::Unit(axis)});
  return dofs;
}

// A base, a hinge with a special name, a joint of two axes, a fixed joint and a mimic joint.
std::vector<Joint> OddJoints() {
  return {{.name = "base", .offset_m = {0, 0, 1}, .dofs = FreeDofs()},
          {.name = "hinge, \"left\"", .parent = 0, .dofs = {{.axis = Vector3d::UnitY()}}},
          {.name = "ball",
           .parent = 1,
           .dofs = {{.axis = Vector3d::UnitX()}, {.axis = Vector3d::UnitZ()}}},
          {.name = "bracket", .parent = 2, .dofs = {}},
          {.name = "follower", .parent = 3, .dofs = {}}};
}

const MimicJoint kFollower = {"follower", "hinge, \"left\"", -2, 0.5};

JointMotion Motion(std::vector<Joint> joints, int frames, unsigned seed = 3) {
  auto skeleton = core::Skeleton::Create("robot", std::move(joints));
  REQUIRE(skeleton.ok());
  JointMotion motion = {std::make_shared<core::Skeleton>(*std::move(skeleton)), 50, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-3, 3);
  motion.angles = core::JointMatrix::NullaryExpr(frames, motion.skeleton->dof_count(),
                                                 [&] { return value(random); });
  return motion;
}

}  // namespace

TEST_CASE("WriteJointTable: exact text of a small robot", "[core][format]") {
  JointMotion motion = Motion(OddJoints(), 2);
  motion.angles.setZero();
  motion.angles(0, 0) = -0.0;
  motion.angles.row(1) << 1, 2, 0.5, 0, 0, 0, 0.1, -0.25, 3;
  const auto text = core::WriteJointTable(motion, {&kFollower, 1});
  REQUIRE(text.ok());
  CHECK(*text ==
        "time_s,root_x_m,root_y_m,root_z_m,root_qx,root_qy,root_qz,root_qw,"
        "\"hinge, \"\"left\"\"\",ball/1,ball/2,follower\n"
        "0,0,0,1,0,0,0,1,0,0,0,0.5\n"
        "0.02,1,2,1.5,0,0,0,1,0.1,-0.25,3,0.3\n");
}

TEST_CASE("WriteJointTable: every double is preserved", "[core][format]") {
  const JointMotion motion = Motion(OddJoints(), 40);
  const Table table = WriteAndParse(motion, {&kFollower, 1});
  REQUIRE(table.rows.size() == 40);
  for (std::size_t t = 0; t < 40; ++t) {
    const auto q = motion.angles.row(static_cast<Eigen::Index>(t));
    CHECK(table.At(t, "time_s") == static_cast<double>(t) / 50);
    CHECK(table.At(t, "hinge, \"left\"") == q[6]);
    CHECK(table.At(t, "ball/1") == q[7]);
    CHECK(table.At(t, "ball/2") == q[8]);
    CHECK(table.At(t, "follower") == -2 * q[6] + 0.5);
    const auto pose = core::ForwardKinematics(*motion.skeleton, q);
    const Eigen::Quaterniond turn(table.At(t, "root_qw"), table.At(t, "root_qx"),
                                  table.At(t, "root_qy"), table.At(t, "root_qz"));
    CHECK(std::abs(turn.norm() - 1) < 1e-14);
    CHECK((turn.toRotationMatrix() - pose[0].linear()).norm() < 1e-13);
    CHECK(Vector3d(table.At(t, "root_x_m"), table.At(t, "root_y_m"), table.At(t, "root_z_m")) ==
          Vector3d(pose[0].translation()));
  }
}

TEST_CASE("WriteJointTable: the quaternion is continuous through full turns", "[core][format]") {
  JointMotion motion = Motion({{.name = "base", .dofs = FreeDofs()}}, 400);
  motion.angles.setZero();
  for (int t = 0; t < 400; ++t) motion.angles(t, 3) = 3 + 0.05 * t;
  const Table table = WriteAndParse(motion);
  CHECK(table.At(0, "root_qw") >= 0);
  for (std::size_t t = 1; t < 400; ++t) {
    double dot = 0;
    for (const char* part : {"root_qx", "root_qy", "root_qz", "root_qw"}) {
      dot += table.At(t, part) * table.At(t - 1, part);
    }
    CHECK(dot == Approx(std::cos(0.025)));
  }
}

TEST_CASE("WriteJointTable: refuses invalid motion", "[core][format]") {
  const auto refusal = [](const JointMotion& motion, std::vector<MimicJoint> mimics = {}) {
    return ErrorMessageOf(core::WriteJointTable(motion, mimics));
  };
  const JointMotion good = Motion(OddJoints(), 3);
  JointMotion bad = good;
  bad.skeleton = nullptr;
  CHECK_THAT(refusal(bad), Contains("joint table: the motion has no skeleton"));
  bad = good;
  bad.angles.conservativeResize(3, 2);
  CHECK_THAT(refusal(bad), Contains("found 2"));
  bad = good;
  bad.angles.conservativeResize(0, good.angles.cols());
  CHECK_THAT(refusal(bad), Contains("no frame"));
  bad = good;
  bad.frame_rate_hz = std::nan("");
  CHECK_THAT(refusal(bad), Contains("frame rate"));
  bad = good;
  bad.angles(2, 1) = std::numeric_limits<double>::infinity();
  CHECK_THAT(refusal(bad), Contains("frame 2"));

  std::vector<Joint> joints = OddJoints();
  joints.push_back({.name = "second", .parent = -1, .dofs = {}});
  CHECK_THAT(refusal(Motion(joints, 1)), Contains("one root, found 'base' and 'second'"));
  joints = OddJoints();
  joints[1].name = "ball/2";
  CHECK_THAT(refusal(Motion(joints, 1)), Contains("two columns would be named 'ball/2'"));
  joints[1].name = "time_s";
  CHECK_THAT(refusal(Motion(joints, 1)), Contains("two columns would be named 'time_s'"));

  for (const MimicJoint& mimic :
       {MimicJoint{"nobody", "ball"}, MimicJoint{"follower", "ball"},
        MimicJoint{"follower", "bracket"}, MimicJoint{"ball", "hinge, \"left\""}}) {
    CHECK_THAT(refusal(good, {mimic}), Contains("mimic"));
  }
  CHECK_THAT(refusal(good, {{"follower", "hinge, \"left\"", std::nan(""), 0}}),
             Contains("not finite"));
}

TEST_CASE("WriteJointTable: real robots keep their pose by forward kinematics",
          "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  for (const char* name :
       {"g1_29dof_rev_1_0", "h1", "atlas_minimal_contact", "jvrc1", "nao", "simple_humanoid"}) {
    CAPTURE(name);
    const std::string bytes = ReadFile(DataDir() / "robots" / (std::string(name) + ".urdf"));
    const auto robot = core::ReadUrdf({.name = name, .bytes = bytes});
    REQUIRE(robot.ok());
    const core::Skeleton& skeleton = robot->skeleton;
    const JointMotion motion = Motion(skeleton.joints(), 5);
    const Table table = WriteAndParse(motion, robot->mimics);
    CHECK(table.columns.size() ==
          8 + static_cast<std::size_t>(skeleton.dof_count()) - 6 + robot->mimics.size());
    for (std::size_t t = 0; t < table.rows.size(); ++t) {
      // As in a robot controller: the pose of the base, then each joint by name.
      Eigen::RowVectorXd q = Eigen::RowVectorXd::Zero(skeleton.dof_count());
      for (int j = 1; j < skeleton.joint_count(); ++j) {
        const Joint& joint = skeleton.joints()[j];
        if (!joint.dofs.empty()) q[skeleton.first_dof(j)] = table.At(t, joint.name);
      }
      const Eigen::Isometry3d base =
          Eigen::Translation3d(table.At(t, "root_x_m"), table.At(t, "root_y_m"),
                               table.At(t, "root_z_m")) *
          Eigen::Quaterniond(table.At(t, "root_qw"), table.At(t, "root_qx"), table.At(t, "root_qy"),
                             table.At(t, "root_qz"));
      const auto relative = core::ForwardKinematics(skeleton, q);
      const auto expected =
          core::ForwardKinematics(skeleton, motion.angles.row(static_cast<Eigen::Index>(t)));
      double max_difference = 0;
      for (int j = 0; j < skeleton.joint_count(); ++j) {
        max_difference =
            std::max(max_difference,
                     ((base * relative[j]).matrix() - expected[j].matrix()).cwiseAbs().maxCoeff());
      }
      CHECK(max_difference < 1e-12);
      for (const MimicJoint& mimic : robot->mimics) {
        CHECK(table.At(t, mimic.joint) ==
              mimic.multiplier * table.At(t, mimic.master) + mimic.offset);
      }
    }
  }
}

}  // namespace motiondb::tests::joint_table_writer_test
