// Accuracy of inverse kinematics on recorded motion, and limit violations of recordings on their
// own skeleton.
#include "tests/support/real_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <map>

#include "core/format/marker_set_file.h"
#include "core/kinematics/inverse_kinematics.h"
#include "core/kinematics/marker_kinematics.h"
#include "tests/core/kinematics/figure.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::real_motion_test {
namespace {

using core::JointMotion;
using core::MarkerMotion;

// Distances between markers and those of inverse kinematics over several clips, cm.
struct Distances {
  std::vector<double> cm;
  int violations = 0;

  void Add(const JointMotion& motion, const core::IkOptions& options) {
    const core::MarkerScheme& scheme = core::StandardScheme();
    const MarkerMotion markers = MarkersOf(scheme, motion);
    const auto kinematics = Kinematics(scheme, motion.skeleton);
    const auto solved = core::SolveInverseKinematics(kinematics, markers, options);
    REQUIRE(solved.ok());
    const MarkerMotion found =
        MarkersOf(scheme, solved->motion, core::SkeletonLegLength(scheme, motion.skeleton).value());
    const core::FrameMatrix apart = found.positions_m - markers.positions_m;
    for (Eigen::Index frame = 0; frame < apart.rows(); ++frame) {
      for (int m = 0; m < kinematics.marker_count(); ++m) {
        cm.push_back(100 * apart.row(frame).segment<3>(3 * m).cast<double>().norm());
      }
    }
    violations += core::CountLimitViolations(solved->motion, 0);
  }

  double Quantile(double share) {
    const auto at =
        cm.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(cm.size() - 1));
    std::nth_element(cm.begin(), at, cm.end());
    return *at;
  }
};

// Recorded angles beyond the file's own limits, per degree of freedom.
struct LimitViolation {
  int frames = 0;
  double max_deg = 0;
};

std::map<std::string, LimitViolation> LimitViolations(const JointMotion& motion) {
  std::map<std::string, LimitViolation> limit_violations;
  int column = 0;
  for (const core::Joint& joint : motion.skeleton->joints()) {
    for (std::size_t k = 0; k < joint.dofs.size(); ++k, ++column) {
      for (const double angle : motion.angles.col(column)) {
        const double beyond =
            std::max(joint.dofs[k].lower - angle, angle - joint.dofs[k].upper) * 180 / M_PI;
        if (!(beyond > 1e-6)) continue;
        LimitViolation& violation = limit_violations[fmt::format("{}.{}", joint.name, k + 1)];
        ++violation.frames;
        violation.max_deg = std::max(violation.max_deg, beyond);
      }
    }
  }
  return limit_violations;
}

// Returns the clips of a list, or all clips of a subject.
std::vector<std::filesystem::path> Clips(const std::string& name) {
  std::vector<std::filesystem::path> clips;
  if (name.ends_with(".tsv")) {
    for (const ListedClip& clip : ReadList(DataDir() / name)) clips.push_back(clip.path);
  } else {
    for (const auto& entry : std::filesystem::directory_iterator(DataDir() / name)) {
      if (entry.path().extension() == ".amc") clips.push_back(entry.path());
    }
  }
  return clips;
}

}  // namespace

TEST_CASE("Inverse kinematics: recorded motion is reproduced", "[core][kinematics][data]") {
  MOTIONDB_REQUIRE_DATA();
  const std::string name = GENERATE("sets/database2.tsv", "cmu/16", "cmu/09", "cmu/02", "cmu/07");
  std::vector<JointMotion> motions;
  for (const auto& clip : Clips(name)) {
    motions.push_back(std::get<JointMotion>(LoadMotion(clip).motion));
  }
  Distances free;
  Distances limited;
  std::map<std::string, LimitViolation> limit_violations;
  Eigen::Index frames = 0;
  int beyond = 0;
  for (const JointMotion& motion : motions) {
    free.Add(motion, {.respect_limits = false});
    limited.Add(motion, {});
    frames += motion.angles.rows();
    beyond += core::CountLimitViolations(motion, 1e-8);
    for (const auto& [dof, more] : LimitViolations(motion)) {
      limit_violations[dof].frames += more.frames;
      limit_violations[dof].max_deg = std::max(limit_violations[dof].max_deg, more.max_deg);
    }
  }
  std::printf(
      "%s, %zu clips, %td frames: marker error in cm, median / 95 %% / largest: "
      "no limits %.4f / %.4f / %.3f, limits %.4f / %.4f / %.3f\n",
      name.c_str(), motions.size(), frames, free.Quantile(0.5), free.Quantile(0.95),
      free.Quantile(1), limited.Quantile(0.5), limited.Quantile(0.95), limited.Quantile(1));
  std::printf("  recorded angles beyond the file's limits: %d (frames x degrees of freedom):",
              beyond);
  for (const auto& [dof, violation] : limit_violations) {
    std::printf(" %s %d (%.1f deg)", dof.c_str(), violation.frames, violation.max_deg);
  }
  std::printf("\n");
  CHECK(free.Quantile(0.5) < 0.1);
  CHECK(free.Quantile(1) < 1);
  CHECK(limited.violations == 0);
  CHECK(limited.Quantile(0.5) < 0.1);
}

}  // namespace motiondb::tests::real_motion_test
