#include "core/kinematics/pose_tracker.h"

namespace motiondb::core {
namespace {

constexpr int kFrameIterations = 30;
constexpr int kFirstAttempts = 12;
constexpr int kLaterAttempts = 6;
// At this error (m, root of the mean square) the pull is twice what it is where all markers fit.
constexpr double kMisfit = 0.005;
// A pose found anew must be this much better (share of the error) to be worth a jump.
constexpr double kWorthAJump = 0.5;

// A marker is off by more than twice what any was in the frame before, and 5 mm.
bool ClearlyWorse(const IkError& error, const IkError& before) {
  return error.largest_m > 2 * before.largest_m + 0.005;
}

// Markers that cannot be met tell less about the pose, by the square of how far off they stay, and
// have several poses next to equally near: without a stronger pull, it would jump between them.
double Pull(double smoothness, const IkError& before) {
  const double misfit = before.rms_m / kMisfit;
  return smoothness * (1 + misfit * misfit);
}

}  // namespace

PoseTracker::PoseTracker(const MarkerKinematics& kinematics, const IkOptions& options)
    : solver_(kinematics, options), search_(kinematics), smoothness_(options.smoothness) {}

IkError PoseTracker::Follow(const Eigen::Ref<const Eigen::RowVectorXf>& markers_m) {
  solver_.Aim(markers_m);
  if (!solver_.has_targets()) return {};
  if (has_begun_) {
    FollowOn();
    solver_.RunOn(last_angles_);
  } else {
    search_.Run(kFirstAttempts, solver_);
    has_begun_ = true;
  }
  last_angles_ = pose().angles;
  last_error_ = solver_.Error();
  return last_error_;
}

void PoseTracker::FollowOn() {
  solver_.Descend(search_.whole(), kFrameIterations, Pull(smoothness_, last_error_));
  if (!ClearlyWorse(solver_.Error(), last_error_)) return;
  // The markers moved further than the pull lets a pose follow.
  solver_.Descend(search_.whole(), kFrameIterations, 0);
  const IkError followed = solver_.Error();
  if (!ClearlyWorse(followed, last_error_)) return;
  // Or to where no way downhill leads.
  const Eigen::RowVectorXd angles = pose().angles;
  search_.Run(kLaterAttempts, solver_);
  if (!(solver_.Error().rms_m < kWorthAJump * followed.rms_m)) solver_.Stand(angles);
}

}  // namespace motiondb::core
