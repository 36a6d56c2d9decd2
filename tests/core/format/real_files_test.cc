// Recorded motion: all files are read, people stand on the floor, and two readers agree on one
// motion.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <vector>

#include "core/motion/forward_kinematics.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::real_files_test {
namespace {

namespace fs = std::filesystem;
using core::FrameMatrix;

absl::StatusOr<core::MotionFile> ReadPath(const fs::path& path, const fs::path& skeleton = {}) {
  const auto format = core::FormatOfPath(path.string());
  REQUIRE(format.ok());
  const std::string name = path.filename().string();
  const std::string bytes = ReadFile(path);
  const std::string asf_name = skeleton.filename().string();
  const std::string asf = skeleton.empty() ? "" : ReadFile(skeleton);
  std::optional<core::SourceFile> asf_file;
  if (!skeleton.empty()) asf_file = {.name = asf_name, .bytes = asf};
  return core::ReadMotionFile(*format, {.name = name, .bytes = bytes}, asf_file);
}

std::vector<fs::path> FilesIn(const fs::path& folder, std::string_view extension) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

FrameMatrix Positions(const core::MotionFile& file) {
  if (const auto* joints = std::get_if<core::JointMotion>(&file.motion)) {
    return core::JointPositions(*joints);
  }
  return std::get<core::MarkerMotion>(file.motion).positions_m;
}

// Returns the heights of all points over all frames, ascending.
std::vector<float> Heights(const core::MotionFile& file) {
  const FrameMatrix positions = Positions(file);
  std::vector<float> heights;
  for (Eigen::Index i = 2; i < positions.size(); i += 3) {
    if (std::isfinite(positions.data()[i])) heights.push_back(positions.data()[i]);
  }
  std::sort(heights.begin(), heights.end());
  return heights;
}

FrameMatrix JointPath(const core::JointMotion& motion, const FrameMatrix& positions,
                      std::string_view joint) {
  const int index = motion.skeleton->FindJoint(joint);
  REQUIRE(index >= 0);
  return positions.middleCols(3 * index, 3);
}

}  // namespace

TEST_CASE("Real files: every clip of the index is read, with all its frames",
          "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  std::istringstream index(ReadFile(DataDir() / "index.tsv"));
  std::string line;
  std::getline(index, line);
  int clips = 0;
  while (std::getline(index, line)) {
    std::vector<std::string> cells(1);
    for (const char c : line) {
      if (c == '\t') {
        cells.emplace_back();
      } else {
        cells.back() += c;
      }
    }
    CAPTURE(cells[0]);
    REQUIRE(cells.size() == 9);
    const auto file =
        ReadPath(DataDir() / cells[0], cells[2].empty() ? fs::path() : DataDir() / cells[2]);
    const core::JointMotion& motion = Joints(file);
    CHECK(motion.angles.rows() == std::stoi(cells[7]));
    CHECK(motion.frame_rate_hz == Approx(std::stod(cells[8])));
    CHECK(motion.angles.allFinite());
    ++clips;
  }
  CHECK(clips > 300);
}

TEST_CASE("Real files: people have a normal height and stand on the floor",
          "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  std::vector<fs::path> paths = FilesIn(DataDir() / "formats/same-motion", ".bvh");
  for (const char* folder : {"formats/other", "cmu/10", "cmu/11", "cmu/13"}) {
    for (const fs::path& path : FilesIn(DataDir() / folder, ".bvh")) paths.push_back(path);
  }
  paths.push_back(DataDir() / "formats/same-motion/02_01.c3d");
  for (const fs::path& path : paths) {
    if (path.filename() == "sinusoidal.bvh") continue;  // a chain, not a person
    CAPTURE(path);
    const auto file = ReadPath(path);
    REQUIRE(file.ok());
    const std::vector<float> heights = Heights(*file);
    CHECK(heights[heights.size() / 1000] > -0.15F);
    CHECK(heights[heights.size() / 50] < 0.25F);
    CHECK(heights.back() > 1.3F);
    CHECK(heights.back() < 2.4F);
  }
}

TEST_CASE("Real files: reports of the files with unusual conventions", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const std::map<std::string, std::string> expected = {
      {"formats/other/sinusoidal.bvh", "unit 0.01 m (assumed), y up (assumed)"},
      {"formats/other/scaled_131_01.bvh", "unit 1 m (deduced), y up (deduced)"},
      {"formats/other/131_01.bvh", "unit 0.0564444 m (deduced), y up (deduced)"},
      {"formats/other/fair_wave_hello.bvh", "unit 0.0564444 m (deduced), z up (deduced)"},
      {"formats/same-motion/02_01.iclone.bvh", "unit 0.01 m (deduced), y up (deduced)"},
      {"formats/same-motion/02_01.c3d", "unit 0.001 m (stated), z up (stated)"},
      {"prediction/train/walking_1.trc", "unit 0.001 m (stated), z up (deduced)"}};
  for (const auto& [path, report] : expected) {
    CAPTURE(path);
    const auto file = ReadPath(DataDir() / path);
    REQUIRE(file.ok());
    CHECK_THAT(core::Describe(file->report), Catch::StartsWith(report));
  }
}

TEST_CASE("Real files: TRC and C3D are read, corrupt files are refused", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  for (const fs::path& path : FilesIn(DataDir() / "prediction/train", ".trc")) {
    const auto file = ReadPath(path);
    CAPTURE(path);
    CHECK(Markers(file).frame_rate_hz == 25);
    CHECK(Markers(file).names.size() == 38);
  }
  for (const fs::path& path : FilesIn(DataDir() / "formats/c3d", ".c3d")) {
    const auto file = ReadPath(path);
    CAPTURE(path);
    CHECK(Markers(file).frame_rate_hz == 50);
  }
  for (const fs::path& path : FilesIn(DataDir() / "formats/damaged", ".c3d")) {
    CAPTURE(path);
    CHECK_THAT(ErrorMessageOf(ReadPath(path)),
               Catch::Contains(": byte ") && Catch::Contains("expected"));
  }
}

TEST_CASE("Real files: four byte orders of one C3D recording agree", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const auto expected = ReadPath(DataDir() / "formats/c3d/sample02_pc_real.c3d");
  for (const char* name :
       {"sample02_Dec_real.c3d", "sample02_pc_int.c3d", "sample02_sgi_int.c3d"}) {
    const auto file = ReadPath(DataDir() / "formats/c3d" / name);
    CHECK(Markers(file).names == Markers(expected).names);
    const FrameMatrix& a = Markers(file).positions_m;
    const FrameMatrix& b = Markers(expected).positions_m;
    REQUIRE(a.rows() == b.rows());
    CHECK(((a - b).array().abs() < 5e-4F || (a.array().isNaN() && b.array().isNaN())).all());
  }
}

TEST_CASE("Real files: AMC and BVH of one motion have the same root path and limb directions",
          "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const auto amc_file = ReadPath(DataDir() / "cmu/02/02_01.amc", DataDir() / "cmu/02/02.asf");
  const auto bvh_file = ReadPath(DataDir() / "formats/same-motion/02_01.motionbuilder.bvh");
  const core::JointMotion& amc = Joints(amc_file);
  const core::JointMotion& bvh = Joints(bvh_file);
  const FrameMatrix a = core::JointPositions(amc);
  const FrameMatrix b = core::JointPositions(bvh);
  REQUIRE(a.rows() == b.rows());
  // The conversion has another skeleton, about 6 % larger, and scales the root path with it.
  const FrameMatrix root_a = JointPath(amc, a, "root");
  const FrameMatrix root_b = JointPath(bvh, b, "Hips");
  const float scale = root_a.cwiseProduct(root_b).sum() / root_b.squaredNorm();
  CHECK(scale == Approx(0.94).margin(0.01));
  CHECK((scale * root_b - root_a).rowwise().norm().maxCoeff() < 2e-3F);
  struct Limb {
    const char* amc[2];
    const char* bvh[2];
  };
  for (const Limb& limb : {Limb{{"lfemur", "ltibia"}, {"LeftUpLeg", "LeftLeg"}},
                           Limb{{"rtibia", "rfoot"}, {"RightLeg", "RightFoot"}},
                           Limb{{"lowerback", "upperback"}, {"LowerBack", "Spine"}},
                           Limb{{"lowerneck", "upperneck"}, {"Neck", "Neck1"}},
                           Limb{{"rhumerus", "rradius"}, {"RightArm", "RightForeArm"}},
                           Limb{{"lradius", "lwrist"}, {"LeftForeArm", "LeftHand"}}}) {
    CAPTURE(limb.amc[0]);
    const FrameMatrix u = JointPath(amc, a, limb.amc[1]) - JointPath(amc, a, limb.amc[0]);
    const FrameMatrix v = JointPath(bvh, b, limb.bvh[1]) - JointPath(bvh, b, limb.bvh[0]);
    const auto cosines = u.cwiseProduct(v).rowwise().sum().array() /
                         (u.rowwise().norm().array() * v.rowwise().norm().array());
    CHECK(cosines.minCoeff() > std::cos(0.11));  // 6 degrees: the skeletons' limbs differ
  }
}

TEST_CASE("Real files: the motion of Debian's assimp-testmodels", "[core][format][data]") {
  const fs::path folder = "/usr/share/assimp/models/BVH";
  if (!fs::exists(folder)) {
    WARN("skipped: assimp-testmodels is not installed");
    return;
  }
  const std::map<std::string, int> frames = {
      {"01_01.bvh", 2752}, {"01_03.bvh", 4511}, {"Boxing_Toes.bvh", 3069}};
  for (const auto& [name, count] : frames) {
    CAPTURE(name);
    CHECK(Joints(ReadPath(folder / name)).angles.rows() == count);
  }
}

}  // namespace motiondb::tests::real_files_test
