// C3D files in a reader that is not ours: the one of DART.
#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <dart/utils/C3D.hpp>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "core/export/writers.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::dart_reads_c3d {
namespace {

core::MarkerMotion RandomMarkers(int markers, int frames) {
  core::MarkerMotion motion;
  for (int m = 0; m < markers; ++m) motion.names.push_back("marker " + std::to_string(m));
  motion.frame_rate_hz = 60;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-4, 4);
  motion.positions_m =
      core::FrameMatrix::NullaryExpr(frames, 3 * markers, [&] { return value(random); });
  return motion;
}

}  // namespace

TEST_CASE("WriteC3d: DART reads the same positions", "[core][export]") {
  for (const int frames : {2, 700}) {
    const core::MarkerMotion motion = RandomMarkers(41, frames);
    const auto bytes = core::WriteC3d(motion);
    REQUIRE(bytes.ok());
    const TemporaryDirectory folder;
    const std::string path = folder / "motion.c3d";
    std::ofstream(path, std::ios::binary) << *bytes;

    std::vector<std::vector<Eigen::Vector3d>> points;
    int read_frames = 0;
    int read_markers = 0;
    double rate_hz = 0;
    REQUIRE(dart::utils::loadC3DFile(path.c_str(), points, &read_frames, &read_markers, &rate_hz));
    CHECK(read_frames == frames);
    CHECK(read_markers == 41);
    CHECK(rate_hz == Approx(60));
    REQUIRE(points.size() == static_cast<std::size_t>(frames));
    double worst_m = 0;
    for (int f = 0; f < frames; ++f) {
      REQUIRE(points[f].size() == 41);
      for (int m = 0; m < 41; ++m) {
        // DART returns metres with y up: our y, z, x.
        const Eigen::Vector3d theirs(points[f][m].z(), points[f][m].x(), points[f][m].y());
        const auto ours = motion.positions_m.row(f).segment<3>(3 * m).transpose().cast<double>();
        worst_m = std::max(worst_m, (theirs - ours).norm());
      }
    }
    CHECK(worst_m < 1e-5);
  }
}

}  // namespace motiondb::tests::dart_reads_c3d
