#include "tests/fuzz/support/motion_properties.h"

#include <cmath>
#include <set>
#include <string_view>

#include "server/engine/representation.h"
#include "tests/fuzz/support/properties.h"

namespace motiondb::tests {
namespace {

const server::RepresentationLimits kLimits{.frame_rate_hz = 60, .max_frames = 20'000};

void HoldsJoints(const core::JointMotion& motion) {
  CheckContract(motion.skeleton != nullptr, "joint motion has a skeleton");
  CheckContract(motion.angles.cols() == motion.skeleton->dof_count(),
                "one column per degree of freedom");
  CheckContract(motion.angles.allFinite(), "angles are finite");
}

void HoldsMarkers(const core::MarkerMotion& motion) {
  CheckContract(motion.positions_m.cols() == 3 * std::ssize(motion.names),
                "three columns per marker");
  const std::set<std::string_view> distinct(motion.names.begin(), motion.names.end());
  CheckContract(distinct.size() == motion.names.size(), "markers have distinct names");
  for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
    for (Eigen::Index m = 0; m < motion.positions_m.cols(); m += 3) {
      const auto point = motion.positions_m.row(t).segment<3>(m);
      CheckContract(point.allFinite() || point.array().isNaN().all(),
                    "a marker has three finite coordinates or none");
    }
  }
}

void HoldsStates(const core::Motion& motion, core::Cleaning cleaning) {
  const auto scheme = core::SourceScheme(motion);
  CheckErrorContract(scheme.status(), absl::StatusCode::kInvalidArgument);
  if (!scheme.ok()) return;
  const auto states = server::RepresentWithin(kLimits, *scheme, motion, cleaning, std::nullopt);
  CheckErrorContract(states.status(), absl::IsResourceExhausted(states.status())
                                          ? absl::StatusCode::kResourceExhausted  // too long
                                          : absl::StatusCode::kInvalidArgument);
  if (!states.ok()) return;
  CheckContract(states->root_path.rows() == states->states.rows(), "one root pose per frame");
  CheckContract(states->root_path.allFinite(), "root poses are finite");
  CheckContract(states->leg_length_m > 0 && std::isfinite(states->leg_length_m),
                "the leg length is positive");
  CheckContract(!states->states.array().isInf().any(), "states are finite");
  // A single frame is no clip and has no velocities.
  const bool is_clip = cleaning == core::GlitchPolicy::kRepair && states->frame_count() > 1;
  CheckContract(!is_clip || states->states.allFinite(), "a stored clip has all markers");
}

}  // namespace

void CheckMotion(const core::Motion& motion) {
  const double rate = server::FrameRate(motion);
  CheckContract(rate > 0 && std::isfinite(rate), "a frame rate is positive");
  if (const auto* joints = std::get_if<core::JointMotion>(&motion)) return HoldsJoints(*joints);
  HoldsMarkers(std::get<core::MarkerMotion>(motion));
}

void CheckMotionFile(const absl::StatusOr<core::MotionFile>& read) {
  CheckErrorContract(read.status(), absl::StatusCode::kInvalidArgument);
  if (!read.ok()) return;
  CheckMotion(read->motion);
  HoldsStates(read->motion, core::GlitchPolicy::kRepair);
  HoldsStates(read->motion, core::kObservation);
}

}  // namespace motiondb::tests
