// Archives of the SMPL family. Joint positions are compared with independent forward kinematics.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "core/format/marker_set_file.h"
#include "core/format/plausibility.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/states.h"
#include "import/npz/npz_reader.h"
#include "import/npz/smpl_body.h"
#include "tests/import/imported.h"
#include "tests/import/npz/npz_files.h"
#include "tests/import/npz/smpl_walk.h"

namespace motiondb::tests::smpl_reader_test {
namespace {

using Catch::Contains;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using importer::SmplModel;

// Returns the maximum distance of the joints of two motions, m.
double MaxDifference(const core::JointMotion& a, const core::JointMotion& b) {
  return (core::JointPositions(a) - core::JointPositions(b)).cwiseAbs().maxCoeff();
}

NpzArrays AistArrays() {
  Gait gait = SmplWalk(SmplModel::kSmpl, false);
  for (double& value : gait.trans) value *= 93.8;
  return {{"smpl_poses", Float64Npy({kGaitFrames, 72}, gait.poses)},
          {"smpl_trans", Float64Npy({kGaitFrames, 3}, gait.trans)},
          {"smpl_scaling", Float64Npy({1}, {93.8})},
          {"smpl_loss", Float64Npy({}, {1.5})}};
}

// Positions of all joints, by Rodrigues' formula along the parents, in the file's axes.
std::vector<Vector3d> Expected(SmplModel model, const Gait& gait, int frame, double stature_m) {
  const auto joints = importer::SmplJoints(model);
  std::vector<Matrix3d> turns(joints.size());
  std::vector<Vector3d> at(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const double* v = gait.poses.data() + (static_cast<std::size_t>(frame) * joints.size() + j) * 3;
    const Matrix3d local = Rodrigues({v[0], v[1], v[2]});
    if (joints[j].parent < 0) {
      const double* t = gait.trans.data() + static_cast<std::size_t>(frame) * 3;
      turns[j] = local;
      at[j] = Vector3d(t[0], t[1], t[2]) + importer::SmplPelvis(model);
      continue;
    }
    const auto parent = static_cast<std::size_t>(joints[j].parent);
    turns[j] = turns[parent] * local;
    at[j] = at[parent] + turns[parent] * (stature_m * (joints[j].rest - joints[parent].rest));
  }
  return at;
}

void CheckPositions(const core::JointMotion& read, SmplModel model, const Gait& gait,
                    double stature_m, const Matrix3d& world_from_file) {
  const auto joints = importer::SmplJoints(model);
  REQUIRE(read.skeleton->joint_count() == static_cast<int>(joints.size()));
  REQUIRE(read.angles.rows() == kGaitFrames);
  for (const int frame : {0, 1, 37, 119}) {
    const auto expected = Expected(model, gait, frame, stature_m);
    const auto poses = core::ForwardKinematics(*read.skeleton, read.angles.row(frame));
    for (std::size_t j = 0; j < joints.size(); ++j) {
      CAPTURE(frame, joints[j].name);
      CHECK(read.skeleton->joints()[j].name == joints[j].name);
      CHECK(read.skeleton->joints()[j].parent == joints[j].parent);
      CHECK((poses[j].translation() - world_from_file * expected[j]).norm() < 1e-9);
    }
  }
}

// Checks that the automatic mapping finds an upright person of this leg length who walks ahead.
void CheckPerson(const core::MotionFile& file, double leg_length_m) {
  std::string note;
  const auto scheme =
      core::FitScheme(core::StandardScheme(), file.motion, core::FitFor::kClip, &note);
  INFO(scheme.status().ToString());
  REQUIRE(scheme.ok());
  const auto states = core::Represent(*scheme, file.motion, 30, core::GlitchPolicy::kRepair);
  INFO(states.status().ToString());
  REQUIRE(states.ok());
  CHECK(states->leg_length_m == Approx(leg_length_m).margin(0.01));
  CHECK(core::CheckBodySize(scheme->set, *states, file.report).ok());
  CHECK(core::CheckPosture(scheme->set, *states, file.report).ok());

  const auto& motion = std::get<core::JointMotion>(file.motion);
  const core::FrameMatrix at = core::JointPositions(motion);
  const auto joint = [&](std::string_view name, Eigen::Index frame) {
    const int j = motion.skeleton->FindJoint(name);
    REQUIRE(j >= 0);
    return Eigen::Vector3f(at.block<1, 3>(frame, 3 * j));
  };
  for (const Eigen::Index frame : {0, 60}) {
    CHECK(joint("head", frame).z() > joint("pelvis", frame).z() + 0.4F);
    CHECK(joint("pelvis", frame).z() > joint("left_knee", frame).z() + 0.4F);
    const float sole = std::min(joint("left_ankle", frame).z(), joint("right_ankle", frame).z());
    CHECK(sole > -0.05F);
    CHECK(sole < 0.3F);
    // It walks where it looks, with its left side on the left.
    const Eigen::Vector3f walked = joint("pelvis", 119) - joint("pelvis", 0);
    const Eigen::Vector3f left = joint("left_hip", frame) - joint("right_hip", frame);
    CHECK(Eigen::Vector3f::UnitZ().cross(walked).normalized().dot(left.normalized()) > 0.95F);
    const Eigen::Vector3f foot = joint("left_foot", 0) - joint("left_ankle", 0);
    CHECK(foot.dot(walked) > 0);
  }
}

const Matrix3d kSame = Matrix3d::Identity();
// World x, y, z of a file with y up.
const Matrix3d kFromYUp = (Matrix3d() << 1, 0, 0, 0, 0, -1, 0, 1, 0).finished();

}  // namespace

TEST_CASE("ReadNpz: AMASS archives of SMPL-H and SMPL-X", "[import]") {
  for (const SmplModel model : {SmplModel::kSmplH, SmplModel::kSmplX}) {
    CAPTURE(importer::NameOf(model));
    const auto file = ReadNpzBytes(NpzOf(AmassWalk(model)));
    const core::JointMotion& motion = Joints(file);
    CHECK(motion.frame_rate_hz == kGaitRate_hz);
    CheckPositions(motion, model, SmplWalk(model, true), 1.75, kSame);
    CheckPerson(*file, 0.491 * 1.75);
    CHECK(MaxStep(motion.angles) < 0.1);
    CHECK(file->report.up_axis == core::UpAxis::kZ);
    CHECK(file->report.up_provenance == core::Provenance::kStated);
    CHECK_THAT(NotesOf(file),
               Contains("body derived from mean proportions (male, stature 1.75 m)"));
    CHECK_THAT(NotesOf(file), Contains("betas are ignored"));
    // Zero angles are the upright T-pose, whatever the file's axes.
    const auto rest = core::ForwardKinematics(
        *motion.skeleton, Eigen::RowVectorXd::Zero(motion.skeleton->dof_count()));
    const int head = motion.skeleton->FindJoint("head");
    CHECK(rest[static_cast<std::size_t>(head)].translation().z() > 0.4);
  }
}

TEST_CASE("ReadNpz: a walk in every direction is read alike", "[import]") {
  for (int i = 0; i < 8; ++i) {
    const double heading = std::numbers::pi / 4 * i;
    CAPTURE(heading);
    const Gait gait = SmplWalk(SmplModel::kSmplH, true, heading);
    NpzArrays arrays = AmassWalk(SmplModel::kSmplH);
    arrays["poses"] = Float64Npy({kGaitFrames, 156}, gait.poses);
    arrays["trans"] = Float64Npy({kGaitFrames, 3}, gait.trans);
    const auto file = ReadNpzBytes(NpzOf(arrays));
    CheckPositions(Joints(file), SmplModel::kSmplH, gait, 1.75, kSame);
    CHECK(MaxStep(Joints(file).angles) < 0.1);
  }
}

TEST_CASE("ReadNpz: AMASS archives in parts", "[import]") {
  NpzArrays arrays = AmassWalk(SmplModel::kSmplX);
  const Gait gait = SmplWalk(SmplModel::kSmplX, true);
  const auto part = [&](std::size_t first, std::size_t count) {
    std::vector<double> numbers;
    for (std::size_t frame = 0; frame < kGaitFrames; ++frame) {
      const auto begin = gait.poses.begin() + static_cast<std::ptrdiff_t>(frame * 165 + first);
      numbers.insert(numbers.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
    }
    return Float64Npy({kGaitFrames, count}, numbers);
  };
  arrays.erase("poses");
  arrays.erase("mocap_framerate");
  arrays["root_orient"] = part(0, 3);
  arrays["pose_body"] = part(3, 63);
  arrays["pose_jaw"] = part(66, 3);
  arrays["pose_eye"] = part(69, 6);
  arrays["pose_hand"] = part(75, 90);
  arrays["mocap_frame_rate"] = Float64Npy({}, {59.999});
  arrays["surface_model_type"] = TextNpy("smplx_locked_head");
  const auto whole = ReadNpzBytes(NpzOf(arrays));
  CheckPositions(Joints(whole), SmplModel::kSmplX, gait, 1.75, kSame);
  CHECK(Joints(whole).frame_rate_hz == 60);

  for (const char* const name : {"pose_jaw", "pose_eye", "pose_hand"}) arrays.erase(name);
  const auto body = ReadNpzBytes(NpzOf(arrays));
  CheckPositions(Joints(body), SmplModel::kSmplX, gait, 1.75, kSame);  // the walk moves no finger
  CHECK_THAT(NotesOf(body), Contains("33 joints without rotations in the file do not move"));

  arrays.erase("surface_model_type");
  CHECK(Joints(ReadNpzBytes(NpzOf(arrays))).skeleton->joint_count() == 24);
  arrays["pose_hand"] = part(75, 90);
  CHECK(Joints(ReadNpzBytes(NpzOf(arrays))).skeleton->joint_count() == 52);
}

TEST_CASE("ReadNpz: SMPL with y up, deduced, and without frame rate", "[import]") {
  const Gait gait = SmplWalk(SmplModel::kSmpl, false);
  NpzArrays arrays = {{"poses", Float64Npy({kGaitFrames, 24, 3}, gait.poses)},
                      {"trans", Float64Npy({kGaitFrames, 3}, gait.trans)},
                      {"gender", TextNpy("b'female'")}};
  const auto file = ReadNpzBytes(NpzOf(arrays));
  CheckPositions(Joints(file), SmplModel::kSmpl, gait, 1.62, kFromYUp);
  CheckPerson(*file, 0.491 * 1.62);
  CHECK(Joints(file).frame_rate_hz == 30);
  CHECK(file->report.up_axis == core::UpAxis::kY);
  CHECK(file->report.up_provenance == core::Provenance::kDeduced);
  CHECK_THAT(NotesOf(file), Contains("the file has no frame rate: 30 Hz assumed"));
  CHECK_THAT(NotesOf(file), !Contains("neutral assumed"));
  NpzArrays other = arrays;
  other["gender"] = TextNpy("unknown");
  CHECK_THAT(NotesOf(ReadNpzBytes(NpzOf(other))),
             Contains("gender 'unknown' is not male, female or neutral: neutral assumed"));
  other.erase("gender");
  CHECK_THAT(NotesOf(ReadNpzBytes(NpzOf(other))),
             Contains("the file states no gender: neutral assumed"));

  arrays["fps"] = Npy(NpyDictionary("<i8", {}), BytesOf<std::int64_t>({25}));
  CHECK(Joints(ReadNpzBytes(NpzOf(arrays))).frame_rate_hz == 25);
  CHECK(Joints(ReadNpzBytes(NpzOf(arrays), {.frame_rate_hz = 50})).frame_rate_hz == 50);

  const Gait z_up = SmplWalk(SmplModel::kSmpl, true);
  arrays["poses"] = Float64Npy({kGaitFrames, 72}, z_up.poses);
  arrays["trans"] = Float64Npy({kGaitFrames, 3}, z_up.trans);
  const auto deduced = ReadNpzBytes(NpzOf(arrays));
  REQUIRE(deduced.ok());
  CHECK(deduced->report.up_axis == core::UpAxis::kZ);
  CheckPositions(Joints(deduced), SmplModel::kSmpl, z_up, 1.62, kSame);
  const auto given = ReadNpzBytes(NpzOf(arrays), {.up_axis = core::UpAxis::kY});
  CheckPositions(Joints(given), SmplModel::kSmpl, z_up, 1.62, kFromYUp);
}

TEST_CASE("ReadNpz: AIST++", "[import]") {
  const auto file = ReadNpzBytes(NpzOf(AistArrays()));
  CheckPositions(Joints(file), SmplModel::kSmpl, SmplWalk(SmplModel::kSmpl, false), 1.69, kFromYUp);
  CheckPerson(*file, 0.491 * 1.69);
  CHECK(Joints(file).frame_rate_hz == 60);
  CHECK_THAT(NotesOf(file), Contains("60 Hz assumed, as in AIST++"));
  NpzArrays wrong = AistArrays();
  wrong["smpl_scaling"] = Float64Npy({1}, {0});
  CHECK_THAT(ErrorMessageOf(ReadNpzBytes(NpzOf(wrong))),
             Contains("array 'smpl_scaling': expected"));
}

TEST_CASE("ReadNpz: numbers of other types and orders are the same motion", "[import]") {
  const Gait gait = SmplWalk(SmplModel::kSmplH, true);
  const auto expected = ReadNpzBytes(NpzOf(AmassWalk(SmplModel::kSmplH)));
  NpzArrays arrays = AmassWalk(SmplModel::kSmplH);
  arrays["poses"] =
      Npy(NpyDictionary(">f8", {kGaitFrames, 156}), BytesOf<double>(gait.poses, true));
  CHECK(MaxDifference(Joints(ReadNpzBytes(NpzOf(arrays))), Joints(expected)) < 1e-12);
  arrays["poses"] = Npy(NpyDictionary("<f4", {kGaitFrames, 156}), BytesOf<float>(gait.poses));
  CHECK(MaxDifference(Joints(ReadNpzBytes(NpzOf(arrays))), Joints(expected)) < 1e-5);
  std::vector<double> fortran;
  for (std::size_t column = 0; column < 156; ++column) {
    for (std::size_t frame = 0; frame < kGaitFrames; ++frame) {
      fortran.push_back(gait.poses[frame * 156 + column]);
    }
  }
  arrays["poses"] = Npy(NpyDictionary("<f8", {kGaitFrames, 156}, true), BytesOf<double>(fortran));
  CHECK(MaxDifference(Joints(ReadNpzBytes(NpzOf(arrays))), Joints(expected)) < 1e-12);
}

TEST_CASE("ReadNpz: texts in object arrays do not prevent reading", "[import]") {
  NpzArrays arrays = AmassWalk(SmplModel::kSmplX);
  arrays["gender"] = Npy("{'descr': '|O', 'fortran_order': False, 'shape': (1,), }\n", "pickle");
  arrays["surface_model_type"] = arrays["gender"];
  CHECK_THAT(NotesOf(ReadNpzBytes(NpzOf(arrays))), Contains("neutral, stature 1.69 m"));
}

TEST_CASE("ReadNpz: errors of SMPL archives", "[import]") {
  const NpzArrays good = AmassWalk(SmplModel::kSmplH);
  const auto error = [&](const std::string& name, const std::string& npy) {
    NpzArrays arrays = good;
    if (npy.empty()) {
      arrays.erase(name);
    } else {
      arrays[name] = npy;
    }
    const std::string message = ErrorMessageOf(ReadNpzBytes(NpzOf(arrays)));
    CHECK_THAT(message, Catch::StartsWith("walk.npz: "));
    return message;
  };
  CHECK_THAT(error("poses", ""),
             Contains("expected the arrays of AMASS or SMPL (poses, trans), AIST++ (smpl_poses, "
                      "smpl_trans) or motiondb (motiondb_version); found betas, dmpls, gender, "
                      "mocap_framerate, trans"));
  CHECK_THAT(error("trans", ""),
             Contains("expected the array 'trans' beside 'poses'; found betas"));
  CHECK_THAT(error("mocap_framerate", ""), Contains("--frame-rate); found betas, dmpls"));
  CHECK_THAT(error("mocap_framerate", Float64Npy({}, {0})),
             Contains("array 'mocap_framerate': expected a frame rate"));
  CHECK_THAT(error("mocap_framerate", Float64Npy({2}, {60, 60})), Contains("expected one number"));
  CHECK_THAT(error("mocap_framerate", TextNpy("60")), Contains("expected one number, found texts"));
  CHECK_THAT(
      error("trans", Float64Npy({kGaitFrames - 1, 3}, std::vector<double>(3 * (kGaitFrames - 1)))),
      Contains("array 'trans': expected 120 frames, as 'poses' has, found 119"));
  CHECK_THAT(error("trans", Float64Npy({kGaitFrames, 4}, std::vector<double>(4 * kGaitFrames))),
             Contains("array 'trans': expected at least one frame of 3 numbers, found the shape "
                      "(120, 4)"));
  CHECK_THAT(error("poses", Float64Npy({kGaitFrames, 150}, std::vector<double>(150 * kGaitFrames))),
             Contains("expected at least one frame of 66 or 72 or 156 or 165 numbers"));
  CHECK_THAT(error("poses", Float64Npy({0, 156}, {})), Contains("found the shape (0, 156)"));
  CHECK_THAT(error("poses", Float64Npy({}, {1})), Contains("found the shape ()"));
  CHECK_THAT(error("poses", TextNpy("male")), Contains("expected numbers, found texts"));

  Gait gait = SmplWalk(SmplModel::kSmplH, true);
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(),
                             -std::numeric_limits<double>::infinity(), 1e300}) {
    std::vector<double> poses = gait.poses;
    poses[156 * 7 + 12] = wrong;
    CHECK_THAT(error("poses", Float64Npy({kGaitFrames, 156}, poses)),
               Contains("array 'poses': frame 7, column 12: expected a finite number, found "));
  }
  CHECK_THAT(ErrorMessageOf(ReadNpzBytes(NpzOf(good), {}, 100'000)), Contains("limit of 100000"));
}

TEST_CASE("ReadNpz: few bytes do not become a long motion", "[import]") {
  // 8-bit rotations: 156 bytes a frame, but 159 doubles in the motion.
  const std::size_t frames = 20'000;
  const std::string bytes =
      NpzOf({{"poses", Npy(NpyDictionary("|i1", {frames, 156}), std::string(frames * 156, '\0'))},
             {"trans", Npy(NpyDictionary("|i1", {frames, 3}), std::string(frames * 3, '\0'))},
             {"fps", Float64Npy({}, {30})}});
  CHECK_THAT(ErrorMessageOf(ReadNpzBytes(bytes, {}, 10'000'000)),
             Contains("the motion of 20000 frames exceeds the limit of 10000000 bytes"));
}

}  // namespace motiondb::tests::smpl_reader_test
