#include "core/planning/body.h"

#include <algorithm>
#include <utility>

#include "core/model/model.h"
#include "core/motion/error.h"

namespace motiondb::core {

Body Body::OfSize(const Model& model, double leg_length_m) { return Body(model, leg_length_m); }

absl::StatusOr<Body> Body::OfSkeleton(const Model& model, const MarkerScheme& scheme,
                                      std::shared_ptr<const Skeleton> skeleton, bool flat_soles) {
  MOTIONDB_ASSIGN_OR_RETURN(const double leg_length_m, SkeletonLegLength(scheme, skeleton));
  Body body(model, leg_length_m);
  MOTIONDB_ASSIGN_OR_RETURN(body.kinematics_,
                            MarkerKinematics::Create(scheme, std::move(skeleton), leg_length_m));
  if (!flat_soles) return body;
  auto soles = FlatSoles(*body.kinematics_, scheme.set, body.feet_, leg_length_m);
  auto stored = StoredFootShapes(model, body.feet_);
  if (soles && stored) {
    body.soles_ = *std::move(soles);
    body.stored_shapes_ = *std::move(stored);
    for (Foot& foot : body.feet_) {
      std::fill(foot.rest_heights.begin(), foot.rest_heights.end(), 0.0F);
    }
  }
  return body;
}

void Body::Fit(FrameMatrix& positions_m) const {
  if (soles_.empty()) return;
  StandOnSoles(stored_feet_, stored_shapes_, leg_length_m_, soles_, positions_m);
}

}  // namespace motiondb::core
