// Recorded motion with its joints renamed to the conventions of other tools: the markers must stay.
#include "core/mapping/fit_scheme.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "core/format/marker_set_file.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/states.h"
#include "tests/support/camera_points.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::fit_scheme_test {
namespace {

using Names = std::map<std::string, std::string>;  // joint of an Acclaim skeleton -> new name

struct Convention {
  const char* name;
  std::array<const char*, 7> middle;  // names of kMiddle
  std::array<const char*, 12> sided;  // names of kSided; '@' stands for the side
  const char* left;
  const char* right;
};

constexpr std::array kMiddle = {"root",      "lowerback", "upperback", "thorax",
                                "lowerneck", "upperneck", "head"};
constexpr std::array kSided = {"hipjoint", "femur",  "tibia", "foot", "toes",    "clavicle",
                               "humerus",  "radius", "wrist", "hand", "fingers", "thumb"};

const Convention kConventions[] = {
    {"Mixamo",
     {"mixamorig:Hips", "mixamorig:Spine", "mixamorig:Spine1", "mixamorig:Spine2", "mixamorig:Neck",
      "mixamorig:Neck1", "mixamorig:Head"},
     {"mixamorig:@Helper", "mixamorig:@UpLeg", "mixamorig:@Leg", "mixamorig:@Foot",
      "mixamorig:@ToeBase", "mixamorig:@Shoulder", "mixamorig:@Arm", "mixamorig:@ForeArm",
      "mixamorig:@ForeArmRoll", "mixamorig:@Hand", "mixamorig:@HandMiddle1",
      "mixamorig:@HandThumb1"},
     "Left",
     "Right"},
    {"Unreal mannequin",
     {"pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "neck_02", "head"},
     {"helper@", "thigh@", "calf@", "foot@", "ball@", "clavicle@", "upperarm@", "lowerarm@",
      "lowerarm_twist_01@", "hand@", "middle_01@", "thumb_01@"},
     "_l",
     "_r"},
    {"VRM",
     {"J_Bip_C_Hips", "J_Bip_C_Spine", "J_Bip_C_Chest", "J_Bip_C_UpperChest", "J_Bip_C_Neck",
      "J_Bip_C_Neck1", "J_Bip_C_Head"},
     {"J_Sec@_Helper", "J_Bip@_UpperLeg", "J_Bip@_LowerLeg", "J_Bip@_Foot", "J_Bip@_ToeBase",
      "J_Bip@_Shoulder", "J_Bip@_UpperArm", "J_Bip@_LowerArm", "J_Bip@_LowerArmTwist",
      "J_Bip@_Hand", "J_Bip@_Middle1", "J_Bip@_Thumb1"},
     "_L",
     "_R"},
    {"Rigify",
     {"DEF-spine", "DEF-spine.001", "DEF-spine.002", "DEF-spine.003", "DEF-spine.004",
      "DEF-spine.005", "DEF-spine.006"},
     {"DEF-helper@", "DEF-thigh@", "DEF-shin@", "DEF-foot@", "DEF-toe@", "DEF-shoulder@",
      "DEF-upper_arm@", "DEF-forearm@", "DEF-forearm@.001", "DEF-hand@", "DEF-palm.02@",
      "DEF-thumb.01@"},
     ".L",
     ".R"},
    {"3ds Max Biped",
     {"Bip01 Pelvis", "Bip01 Spine", "Bip01 Spine1", "Bip01 Spine2", "Bip01 Neck", "Bip01 Neck1",
      "Bip01 Head"},
     {"Bip01 @ Helper", "Bip01 @ Thigh", "Bip01 @ Calf", "Bip01 @ Foot", "Bip01 @ Toe0",
      "Bip01 @ Clavicle", "Bip01 @ UpperArm", "Bip01 @ Forearm", "Bip01 @ ForeTwist",
      "Bip01 @ Hand", "Bip01 @ Finger2", "Bip01 @ Finger0"},
     "L",
     "R"},
    {"Xsens MVN",
     {"Pelvis", "L5", "L3", "T12", "T8", "Neck", "Head"},
     {"@Origin", "@UpperLeg", "@LowerLeg", "@Foot", "@Toe", "@Shoulder", "@UpperArm", "@ForeArm",
      "@WristHelper", "@Hand", "@Fingers", "@Thumb"},
     "Left",
     "Right"},
    {"Bandai-Namco",
     {"joint_Root", "Hips", "Spine", "Chest", "Neck", "Neck1", "Head"},
     {"Helper@", "UpperLeg@", "LowerLeg@", "Foot@", "Toes@", "Shoulder@", "UpperArm@", "LowerArm@",
      "LowerArmTwist@", "Hand@", "Middle@", "Thumb@"},
     "_L",
     "_R"},
    {"SMPL",
     {"Pelvis", "Spine1", "Spine2", "Spine3", "Neck", "Neck2", "Head"},
     {"@_Helper", "@_Hip", "@_Knee", "@_Ankle", "@_Foot", "@_Collar", "@_Shoulder", "@_Elbow",
      "@_ElbowTwist", "@_Wrist", "@_Hand", "@_Thumb"},
     "L",
     "R"},
    {"DAZ Genesis 8",
     {"hip", "abdomenLower", "abdomenUpper", "chestLower", "neckLower", "neckUpper", "head"},
     {"@Helper", "@ThighBend", "@Shin", "@Foot", "@Toe", "@Collar", "@ShldrBend", "@ForearmBend",
      "@ForearmTwist", "@Hand", "@Mid1", "@Thumb1"},
     "l",
     "r"},
    {"SOMA",
     {"Hips", "Spine1", "Spine2", "Chest", "Neck1", "Neck2", "Head"},
     {"@Helper", "@Leg", "@Shin", "@Foot", "@ToeBase", "@Shoulder", "@Arm", "@ForeArm",
      "@ForeArmTwist", "@Hand", "@HandMiddle1", "@HandThumb1"},
     "Left",
     "Right"},
    {"OptiTrack Motive",
     {"Hip", "Ab", "Ab2", "Chest", "Neck", "Neck1", "Head"},
     {"@Helper", "@Thigh", "@Shin", "@Foot", "@Toe", "@Shoulder", "@UArm", "@FArm", "@FArmRoll",
      "@Hand", "@HandEnd", "@Thumb"},
     "L",
     "R"},
    {"Kinect v2",
     {"SpineBase", "Spine1", "SpineMid", "Spine2", "SpineShoulder", "Neck", "Head"},
     {"Helper@", "Hip@", "Knee@", "Ankle@", "Foot@", "Clavicle@", "Shoulder@", "Elbow@",
      "ElbowRoll@", "Wrist@", "Hand@", "Thumb@"},
     "Left",
     "Right"},
};

// Returns the joints' new names. REQUIRES: an Acclaim skeleton of the CMU or HDM05.
Names NamesIn(const Convention& convention) {
  Names names;
  for (std::size_t i = 0; i < kMiddle.size(); ++i) names[kMiddle[i]] = convention.middle[i];
  for (std::size_t i = 0; i < kSided.size(); ++i) {
    for (const auto& [letter, side] : {std::pair("l", convention.left), {"r", convention.right}}) {
      std::string name = convention.sided[i];
      name.replace(name.find('@'), 1, side);
      names[std::string(letter) + kSided[i]] = name;
    }
  }
  return names;
}

core::JointMotion Renamed(const core::JointMotion& motion, const Names& names) {
  std::vector<core::Joint> joints = motion.skeleton->joints();
  for (core::Joint& joint : joints) {
    const bool is_end = joint.name.ends_with("_end");
    const std::string base = is_end ? joint.name.substr(0, joint.name.size() - 4) : joint.name;
    joint.name = names.at(base) + (is_end ? "_end" : "");
  }
  auto skeleton = core::Skeleton::Create("renamed", std::move(joints));
  REQUIRE(skeleton.ok());
  return {std::make_shared<const core::Skeleton>(*std::move(skeleton)), motion.frame_rate_hz,
          motion.angles};
}

core::MarkerMotion Markers(const core::MarkerScheme& scheme, const core::Motion& motion) {
  auto markers = core::ApplyScheme(scheme, motion);
  INFO(markers.status().ToString());
  REQUIRE(markers.ok());
  return *std::move(markers);
}

// Returns the median distance of each marker between two motions, leg lengths, ascending.
std::vector<double> Distances(const core::MarkerMotion& a, const core::MarkerMotion& b) {
  const double leg = *core::EstimateLegLength(core::StandardScheme().set, a);
  std::vector<double> medians;
  for (std::size_t m = 0; m < a.names.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(3 * m);
    const auto difference =
        a.positions_m.middleCols<3>(column) - b.positions_m.middleCols<3>(column);
    std::vector<double> distances;
    for (Eigen::Index t = 0; t < difference.rows(); ++t) {
      distances.push_back(difference.row(t).norm() / leg);
    }
    std::ranges::nth_element(distances, distances.begin() + std::ssize(distances) / 2);
    medians.push_back(distances[distances.size() / 2]);
  }
  std::ranges::sort(medians);
  return medians;
}

core::JointMotion Recorded(const std::string& path) {
  return std::get<core::JointMotion>(LoadMotion(DataDir() / path).motion);
}

const char* const kClips[] = {"cmu/02/02_01.amc", "cmu/49/49_02.amc",
                              "hdm05/HDM_bd_depositFloorR_001_120.amc"};

TEST_CASE("FitScheme: renamed joints give the same markers", "[core][mapping]") {
  MOTIONDB_REQUIRE_DATA();
  for (const char* const clip : kClips) {
    const core::JointMotion motion = Recorded(clip);
    const core::MarkerMotion expected = Markers(core::StandardScheme(), motion);
    for (const Convention& convention : kConventions) {
      CAPTURE(clip, convention.name);
      const core::Motion renamed = Renamed(motion, NamesIn(convention));
      std::string note;
      const auto fitted =
          core::FitScheme(core::StandardScheme(), renamed, core::FitFor::kClip, &note);
      INFO(fitted.status().ToString());
      REQUIRE(fitted.ok());
      CHECK_THAT(note, Catch::StartsWith("joints mapped automatically"));
      const auto distances = Distances(expected, Markers(*fitted, renamed));
      CHECK(distances[distances.size() / 2] < 0.01);
      CHECK(distances.back() < 0.16);
    }
  }
}

TEST_CASE("FitScheme: joints without meaningful names are mapped by structure", "[core][mapping]") {
  MOTIONDB_REQUIRE_DATA();
  const core::JointMotion motion = Recorded("cmu/02/02_01.amc");
  Names names;
  for (const core::Joint& joint : motion.skeleton->joints()) {
    if (!joint.name.ends_with("_end")) names[joint.name] = "j" + std::to_string(names.size());
  }
  const core::Motion renamed = Renamed(motion, names);
  const auto fitted = core::FitScheme(core::StandardScheme(), renamed, core::FitFor::kClip);
  INFO(fitted.status().ToString());
  REQUIRE(fitted.ok());
  const auto distances =
      Distances(Markers(core::StandardScheme(), motion), Markers(*fitted, renamed));
  CHECK(distances.back() < 0.05);
}

TEST_CASE("FitScheme: names of the wrong side are reported, not followed", "[core][mapping]") {
  MOTIONDB_REQUIRE_DATA();
  for (const char* const clip : kClips) {
    CAPTURE(clip);
    Convention mirrored = kConventions[1];
    std::swap(mirrored.left, mirrored.right);
    const auto fitted = core::FitScheme(
        core::StandardScheme(), Renamed(Recorded(clip), NamesIn(mirrored)), core::FitFor::kClip);
    REQUIRE(fitted.status().code() == absl::StatusCode::kInvalidArgument);
    CHECK_THAT(std::string(fitted.status().message()), Catch::Contains("mirrored"));
  }
}

TEST_CASE("FitScheme: names of different sides in one limb are reported", "[core][mapping]") {
  MOTIONDB_REQUIRE_DATA();
  Names names = NamesIn(kConventions[1]);
  std::swap(names.at("lfemur"), names.at("rfemur"));
  std::swap(names.at("ltibia"), names.at("rtibia"));
  const auto fitted = core::FitScheme(core::StandardScheme(), Renamed(Recorded(kClips[0]), names),
                                      core::FitFor::kClip);
  REQUIRE(fitted.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(fitted.status().message()), Catch::Contains("names of sides"));
}

TEST_CASE("FitScheme: skeletons of other sources give nearly the markers of their own mapping",
          "[core][mapping]") {
  MOTIONDB_REQUIRE_DATA();
  for (const char* const path :
       {"formats/pairs/02_01.daz.bvh", "cmu/10/10_01.bvh",
        "formats/same-motion/02_01.motionbuilder.bvh", "formats/same-motion/02_01.iclone.bvh"}) {
    CAPTURE(path);
    const core::JointMotion motion = Recorded(path);
    core::MarkerScheme without_mappings = core::StandardScheme();
    without_mappings.mappings.clear();
    const auto fitted = core::FitScheme(without_mappings, motion, core::FitFor::kClip);
    INFO(fitted.status().ToString());
    REQUIRE(fitted.ok());
    const auto distances =
        Distances(Markers(core::StandardScheme(), motion), Markers(*fitted, motion));
    CHECK(distances[distances.size() / 2] < 0.08);
  }
}

TEST_CASE("FitScheme: a skeleton without toes gets toes in front of its ankles",
          "[core][mapping]") {
  MOTIONDB_REQUIRE_DATA();
  const core::JointMotion motion = Recorded("cmu/02/02_01.amc");
  std::vector<core::Joint> joints;
  std::vector<int> new_index;
  std::vector<Eigen::Index> columns;
  for (int j = 0; j < motion.skeleton->joint_count(); ++j) {
    const core::Joint& joint = motion.skeleton->joints()[j];
    const bool is_toe = joint.name.find("toes") != std::string::npos;
    new_index.push_back(is_toe ? -1 : static_cast<int>(joints.size()));
    if (is_toe) continue;
    joints.push_back(joint);
    if (joint.parent >= 0) joints.back().parent = new_index[joint.parent];
    for (std::size_t d = 0; d < joint.dofs.size(); ++d) {
      columns.push_back(motion.skeleton->first_dof(j) + static_cast<Eigen::Index>(d));
    }
  }
  auto skeleton = core::Skeleton::Create("no toes", std::move(joints));
  REQUIRE(skeleton.ok());
  core::JointMotion without{
      std::make_shared<const core::Skeleton>(*std::move(skeleton)), motion.frame_rate_hz, {}};
  without.angles = motion.angles(Eigen::all, columns);
  const auto fitted = core::FitScheme(core::StandardScheme(), without, core::FitFor::kClip);
  INFO(fitted.status().ToString());
  REQUIRE(fitted.ok());
  const auto distances =
      Distances(Markers(core::StandardScheme(), motion), Markers(*fitted, without));
  CHECK(distances.back() < 0.12);
}

TEST_CASE("FitScheme: a camera's 17 points are stored whole and observed in part",
          "[core][mapping]") {
  MOTIONDB_REQUIRE_DATA();
  const core::MarkerMotion markers = Markers(core::StandardScheme(), Recorded("cmu/02/02_01.amc"));
  core::MarkerMotion seen{{}, markers.frame_rate_hz, {}};
  seen.positions_m.resize(markers.positions_m.rows(), 3 * std::ssize(kCameraPoints));
  const auto column = [&](const std::string& name) {
    return 3 * (std::ranges::find(markers.names, name) - markers.names.begin());
  };
  for (const auto& [name, marker] : kCameraPoints) {
    seen.positions_m.middleCols<3>(3 * std::ssize(seen.names)) =
        markers.positions_m.middleCols<3>(column(marker));
    seen.names.emplace_back(name);
  }
  std::string note;
  const auto observed = core::FitScheme(core::StandardScheme(), seen, core::FitFor::kQuery, &note);
  REQUIRE(observed.ok());
  CHECK(note.find("derived") == std::string::npos);
  const auto partial = core::ApplyScheme(*observed, seen);
  REQUIRE(partial.ok());
  for (const char* missing : {"Waist", "Spine", "Neck", "LToe", "RHeel", "RHand"}) {
    CAPTURE(missing);
    CHECK(partial->positions_m.middleCols<3>(column(missing)).array().isNaN().all());
  }
  CHECK(partial->positions_m.middleCols<3>(column("LElbow")).allFinite());

  const auto stored = core::FitScheme(core::StandardScheme(), seen, core::FitFor::kClip, &note);
  REQUIRE(stored.ok());
  CHECK_THAT(note, Catch::Contains("derived from other points: Waist, Spine, Neck"));
  std::vector<std::string> notes;
  const auto states =
      core::Represent(*stored, seen, 60, core::GlitchPolicy::kRepair, std::nullopt, &notes);
  INFO(states.status().ToString());
  REQUIRE(states.ok());
  CHECK(states->states.allFinite());
  CHECK_THAT(notes.back(), Catch::Contains("LToe, RToe, LHeel, RHeel"));
}

// Thousands of equal pairs of limbs: all their combinations take half a minute.
TEST_CASE("FitScheme: the search is bounded in a bush of equal limbs", "[core][mapping][hostile]") {
  std::vector<core::Joint> joints(1);
  joints[0].name = "j0";
  const auto add = [&](int parent, const Eigen::Vector3d& offset_m) {
    joints.push_back(
        {.name = "j" + std::to_string(joints.size()), .parent = parent, .offset_m = offset_m});
    return static_cast<int>(joints.size()) - 1;
  };
  int trunk = 0;
  while (joints.size() < 1900) {
    trunk = add(trunk, {0, 0, 0.01});
    for (int limb = 0; limb < 11; ++limb) {
      add(add(add(trunk, {0.01 * limb, 0, 0.1}), {0, 0, 0.4}), {0, 0, 0.4});
    }
  }
  auto bush = core::Skeleton::Create("bush", joints);
  REQUIRE(bush.ok());
  const core::JointMotion motion{std::make_shared<const core::Skeleton>(*std::move(bush)), 30,
                                 core::JointMatrix::Zero(24, 0)};
  CHECK(!core::FitScheme(core::StandardScheme(), motion, core::FitFor::kClip).ok());
}

TEST_CASE("FitScheme: what is no person is rejected with a reason", "[core][mapping]") {
  std::vector<core::Joint> joints(1);
  joints[0].name = "base";
  for (int j = 1; j < 12; ++j) {
    joints.push_back({.name = "link" + std::to_string(j), .parent = j - 1, .offset_m = {0, 0, 1}});
  }
  auto chain = core::Skeleton::Create("chain", joints);
  REQUIRE(chain.ok());
  const core::JointMotion motion{std::make_shared<const core::Skeleton>(*std::move(chain)), 30,
                                 core::JointMatrix::Zero(5, 0)};
  const auto fitted = core::FitScheme(core::StandardScheme(), motion, core::FitFor::kClip);
  REQUIRE(fitted.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(fitted.status().message()),
             Catch::Contains("no figure of a person") && Catch::Contains("'base'"));
}

}  // namespace
}  // namespace motiondb::tests::fit_scheme_test
