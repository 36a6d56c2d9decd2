// Seeds of the readers: small files of every format, mostly made with the tests' own writers.
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/export/writers.h"
#include "core/format/marker_set_file.h"
#include "core/format/readers.h"
#include "storage/blob/motion_codec.h"
#include "tests/client/random_annotations.h"
#include "tests/core/format/biped_table.h"
#include "tests/core/format/c3d_builder.h"
#include "tests/core/format/odd_robot.h"
#include "tests/core/format/some_points.h"
#include "tests/fuzz/seeds/seed_file.h"
#include "tests/fuzz/seeds/small_files.h"
#include "tests/import/npz/npz_files.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests {
namespace {

using namespace std::string_literals;

TEST_CASE("Seeds: BVH", "[seeds]") {
  const std::string walk = WriteBvh({.frame_count = 3});
  WriteSeed("bvh_fuzz", "walk", walk);
  WriteSeed("bvh_fuzz", "small", kSmallBvh);
  const auto read = core::ReadBvh({"walk.bvh", walk}, {});
  REQUIRE(read.ok());
  const auto written = core::WriteBvh(std::get<core::JointMotion>(read->motion));
  REQUIRE(written.ok());
  WriteSeed("bvh_fuzz", "written", *written);
}

TEST_CASE("Seeds: ASF and AMC", "[seeds]") { WriteSeed("amc_fuzz", "small", SmallAmcWithAsf()); }

TEST_CASE("Seeds: TRC", "[seeds]") { WriteSeed("trc_fuzz", "small", kSmallTrc); }

TEST_CASE("Seeds: C3D", "[seeds]") {
  C3dBuilder builder;
  builder.labels = {"LASI", "RASI", "HEAD"};
  builder.frames.assign(2, {{100, 0, 900, 0}, {-100, 0, 900, 0}, {0, 0, 1700, -1}});
  WriteSeed("c3d_fuzz", "intel", builder.Build());
  builder.real = false;
  builder.processor = core::C3dProcessor::kDec;
  WriteSeed("c3d_fuzz", "dec", builder.Build());
  builder.processor = core::C3dProcessor::kMips;
  builder.analog_per_frame = 2;
  builder.long_count = true;
  WriteSeed("c3d_fuzz", "mips", builder.Build());
}

TEST_CASE("Seeds: annotations", "[seeds]") {
  const auto annotations = RandomAnnotations(1, 1, 2);
  for (const auto& [target, format] :
       {std::pair("annotation_tsv_fuzz", client::AnnotationFormat::kTsv),
        std::pair("annotation_json_fuzz", client::AnnotationFormat::kJson),
        std::pair("babel_fuzz", client::AnnotationFormat::kBabel),
        std::pair("text_grid_fuzz", client::AnnotationFormat::kTextGrid)}) {
    const auto bytes = client::WriteAnnotations(format, RandomClips(1), annotations);
    REQUIRE(bytes.ok());
    WriteSeed(target, "written", *bytes);
  }
}

TEST_CASE("Seeds: URDF", "[seeds]") {
  WriteSeed("urdf_fuzz", "odd", kRobot);
  WriteSeed("urdf_fuzz", "arm", kSmallUrdf);
}

TEST_CASE("Seeds: marker sets", "[seeds]") {
  WriteSeed("marker_set_fuzz", "small", kSmallMarkerSet);
  WriteSeed("marker_set_fuzz", "standard", core::WriteMarkerSetFile(core::StandardScheme()));
}

TEST_CASE("Seeds: CSV", "[seeds]") {
  const std::string robot = std::string(kBiped) + '\0';
  WriteSeed("csv_fuzz", "joints", robot + std::string(kTable));
  // A robot that begins as a gzip file and ends there.
  WriteSeed("csv_fuzz", "truncated_gzip", "\x1f\x8b\0"s + std::string(kTable));
  WriteSeed("csv_fuzz", "plain", robot + "0,0,0.8,0,0,0,1,0.1,0.2,0.3,0.4\n"s);
  WriteSeed("csv_fuzz", "bones_seed",
            robot + "Frame,root_translateX,root_translateY,root_translateZ,root_rotateX,"s +
                "root_rotateY,root_rotateZ,l_hip_dof,r_hip_dof,l_knee_dof,r_knee_dof\n"s +
                "0,1,2,80,0,0,90,10,20,30,40\n1,1,2,80,0,0,90,10,20,30,40\n"s);
  const auto points = core::WritePointTable(PointsWithGaps({"LHip", "RHip", "head"}, 4));
  REQUIRE(points.ok());
  WriteSeed("csv_fuzz", "points", *points);
}

// Returns an archive, and its members for a target that makes the archive itself.
std::pair<std::string, std::string> BothNpz(
    const std::vector<std::pair<std::string, std::string>>& arrays) {
  std::vector<ZipMember> members;
  std::string parts = "\1";
  for (const auto& [array, content] : arrays) {
    const std::string name = array + ".npy";
    members.push_back({.name = name, .content = content, .deflated = true});
    parts += static_cast<char>(name.size());
    parts += static_cast<char>(content.size() & 0xff);
    parts += static_cast<char>(content.size() >> 8);
    parts += name + content;
  }
  return {'\0' + Zip(members), parts};
}

TEST_CASE("Seeds: NPZ", "[seeds]") {
  const auto zeros = [](std::size_t columns) {
    return Float64Npy({2, columns}, std::vector<double>(2 * columns, 0));
  };
  const std::string places = Float64Npy({2, 3}, {0, 0, 1, 0, 0.1, 1});
  const std::string version = Npy(NpyDictionary("<i4", {}), BytesOf<std::int32_t>({1}));
  const std::string rate = Float64Npy({}, {60});
  const std::vector<std::pair<std::string, std::vector<std::pair<std::string, std::string>>>>
      archives = {{"amass",
                   {{"poses", zeros(156)},
                    {"trans", places},
                    {"mocap_framerate", rate},
                    {"gender", TextNpy("female")}}},
                  {"parts",
                   {{"root_orient", zeros(3)},
                    {"pose_body", zeros(63)},
                    {"pose_hand", zeros(90)},
                    {"trans", places},
                    {"surface_model_type", TextNpy("smplh")},
                    {"fps", rate}}},
                  {"aist",
                   {{"smpl_poses", zeros(72)},
                    {"smpl_trans", places},
                    {"smpl_scaling", Float64Npy({1}, {90})}}},
                  {"markers",
                   {{"motiondb_version", version},
                    {"frame_rate_hz", rate},
                    {"marker_names", Npy(NpyDictionary("|S4", {1}), "head")},
                    {"positions_m", Npy(NpyDictionary(">f4", {2, 1, 3}, true),
                                        BytesOf<float>({0, 0.1, 0, 0, 1.7, 1.7}, true))}}},
                  {"joints",
                   {{"motiondb_version", version},
                    {"frame_rate_hz", rate},
                    {"joint_names", Npy(NpyDictionary("|S4", {2}), "hipshead")},
                    {"parents", Npy(NpyDictionary("<i4", {2}), BytesOf<std::int32_t>({-1, 0}))},
                    {"offsets_m", Float64Npy({2, 3}, {0, 0, 1, 0, 0, 0.7})},
                    {"rest_rotations", Float64Npy({2, 4}, {0, 0, 0, 1, 0, 0, 0, 1})},
                    {"local_rotations", Float64Npy({1, 2, 4}, {0, 0, 0, 1, 0, 0, 0, 1})},
                    {"local_positions_m", Float64Npy({1, 2, 3}, {0, 0, 1, 0, 0, 0.7})},
                    {"positions_m", Float64Npy({1, 2, 3}, {0, 0, 1, 0, 0, 1.7})}}}};
  for (const auto& [name, arrays] : archives) {
    const auto [archive, members] = BothNpz(arrays);
    WriteSeed("npz_fuzz", name, archive);
    WriteSeed("npz_fuzz", name + "_members", members);
  }
}

TEST_CASE("Seeds: gzip", "[seeds]") {
  const std::string member = Deflated(kSmallBvh, true);
  WriteSeed("gzip_fuzz", "member", '\0' + member);
  WriteSeed("gzip_fuzz", "members", '\0' + member + Deflated("", true) + member);
  WriteSeed("gzip_fuzz", "content", '\1' + std::string(kSmallBvh));
}

TEST_CASE("Seeds: motion of motiondb-import", "[seeds]") {
  const auto write = [](const std::string& name, const core::MotionFile& file) {
    storage::StringSink sink;
    REQUIRE(storage::EncodeMotion(file, sink).ok());
    WriteSeed("motion_codec_fuzz", name, sink.bytes());
  };
  const auto joints = core::ReadBvh({"small.bvh", kSmallBvh}, {});
  REQUIRE(joints.ok());
  write("joints", *joints);
  core::MotionFile markers;
  markers.motion = PointsWithGaps({"LHip", "RHip", "head"}, 4);
  markers.report.notes = {"frames start at 27", ""};
  write("markers", markers);
}

}  // namespace
}  // namespace motiondb::tests
