#include "core/planning/body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/kinematics/pose_solver.h"
#include "core/model/model.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr int kSoleFrames = 4000;
constexpr float kFlatHeight = 0.025F;  // leg lengths from rest height
constexpr float kFlatSpeed = 0.15F;    // leg lengths per second
constexpr int kMinFlatFrames = 5;      // frames
constexpr double kLevel = 0.01;  // leg lengths: maximum height difference of level contact markers
constexpr double kTouch = 0.02;  // leg lengths: height scale of the support weights

std::vector<Eigen::Index> ColumnsOfContacts(const Foot& foot) {
  std::vector<Eigen::Index> columns;
  for (const int marker : foot.contact_markers) {
    columns.push_back(std::find(foot.foot_markers.begin(), foot.foot_markers.end(), marker) -
                      foot.foot_markers.begin());
  }
  return columns;
}

Eigen::Matrix3d TurnAboutZ(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

// Transforms a foot (3 x foot_markers) to the axes of a shape; heights stay.
FootShape Aligned(const Foot& foot, Eigen::Matrix3Xd points) {
  const std::vector<Eigen::Index> contacts = ColumnsOfContacts(foot);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Index c : contacts)
    middle += points.col(c) / static_cast<double>(contacts.size());
  middle.z() = 0;
  const auto [rear, front] = std::minmax_element(
      contacts.begin(), contacts.end(),
      [&](Eigen::Index a, Eigen::Index b) { return points(0, a) < points(0, b); });
  const Eigen::Vector3d along = points.col(*front) - points.col(*rear);
  return TurnAboutZ(-std::atan2(along.y(), along.x())) * (points.colwise() - middle);
}

bool IsFlat(const Foot& foot, const Eigen::RowVectorXf& state) {
  for (std::size_t i = 0; i < foot.contact_markers.size(); ++i) {
    const int m = foot.contact_markers[i];
    if (std::abs(state[6 * m + 2] - foot.rest_heights[i]) > kFlatHeight ||
        state.segment<3>(6 * m + 3).norm() > kFlatSpeed) {
      return false;
    }
  }
  return true;
}

// Returns the support weights of a foot's contact markers: nearly 1 for the lowest.
Eigen::VectorXd Carrying(const Foot& foot, const Eigen::Ref<const Eigen::RowVectorXf>& positions_m,
                         double leg_length_m) {
  Eigen::VectorXd shares(static_cast<Eigen::Index>(foot.contact_markers.size()));
  for (Eigen::Index i = 0; i < shares.size(); ++i) {
    const double height =
        static_cast<double>(positions_m[3 * foot.contact_markers[i] + 2]) / leg_length_m -
        static_cast<double>(foot.rest_heights[i]);
    shares[i] = std::exp(-height / kTouch);
  }
  return shares / shares.sum();
}

// Returns the shapes of the stored feet, in leg lengths, from frames in which they stand flat.
// Nothing if a foot has a single contact marker or never stands flat.
std::optional<std::vector<FootShape>> StoredFootShapes(const Model& model, const Feet& feet) {
  std::vector<FootShape> shapes;
  const int every = std::max(1, model.frame_count() / kSoleFrames);
  for (const Foot& foot : feet) {
    if (foot.contact_markers.size() < 2) return std::nullopt;
    FootShape sum = FootShape::Zero(3, static_cast<Eigen::Index>(foot.foot_markers.size()));
    int flat = 0;
    for (int f = 0; f < model.frame_count(); f += every) {
      const Eigen::RowVectorXf state = model.states().row(f).cwiseProduct(model.scale().divisor);
      if (!IsFlat(foot, state)) continue;
      Eigen::Matrix3Xd points(3, sum.cols());
      for (Eigen::Index i = 0; i < points.cols(); ++i) {
        points.col(i) = state.segment<3>(6 * foot.foot_markers[i]).cast<double>().transpose();
      }
      sum += Aligned(foot, std::move(points));
      ++flat;
    }
    if (flat < kMinFlatFrames) return std::nullopt;
    shapes.push_back(sum / flat);
  }
  return shapes;
}

// Returns the shapes (m) of a skeleton's feet at zero angles, if it has flat soles (level contact
// markers, as on robots); otherwise nothing.
std::optional<std::vector<FootShape>> FlatSoles(const MarkerKinematics& kinematics,
                                                const MarkerSet& set, const Feet& feet,
                                                double leg_length_m) {
  MarkerPose pose = kinematics.NewPose();
  kinematics.Place(pose);
  const Eigen::Vector3d across =
      pose.markers_m.col(set.landmarks.left_hip) - pose.markers_m.col(set.landmarks.right_hip);
  const Eigen::Matrix3d to_front =
      TurnAboutZ(std::numbers::pi / 2 - std::atan2(across.y(), across.x()));
  std::vector<FootShape> soles;
  for (const Foot& foot : feet) {
    if (foot.contact_markers.size() < 2) return std::nullopt;
    Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(foot.foot_markers.size()));
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      points.col(i) = to_front * pose.markers_m.col(foot.foot_markers[i]);
    }
    Eigen::VectorXd heights(static_cast<Eigen::Index>(foot.contact_markers.size()));
    const std::vector<Eigen::Index> contacts = ColumnsOfContacts(foot);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      heights[static_cast<Eigen::Index>(i)] = points(2, contacts[i]);
    }
    if (heights.maxCoeff() - heights.minCoeff() > kLevel * leg_length_m) return std::nullopt;
    points.row(2).array() -= heights.mean();
    soles.push_back(Aligned(foot, std::move(points)));
  }
  return soles;
}

// Moves a body's soles to the stored feet (frames x 3 N_v, m): each foot keeps its direction, tilt
// and support point, and the rest of the body is raised or lowered by the difference of the ankle
// heights. `stored` in leg lengths, `soles` in m.
void StandOnSoles(const Feet& feet, const std::vector<FootShape>& stored, double leg_length_m,
                  const std::vector<FootShape>& soles, FrameMatrix& positions_m) {
  // Height difference of the ankles above these soles and above the stored ones.
  double raise = 0;
  std::vector<bool> of_foot(static_cast<std::size_t>(positions_m.cols() / 3), false);
  for (std::size_t i = 0; i < feet.size(); ++i) {
    raise += (soles[i](2, 0) - leg_length_m * stored[i](2, 0)) / static_cast<double>(feet.size());
    for (const int marker : feet[i].foot_markers) of_foot[marker] = true;
  }
  for (Eigen::Index t = 0; t < positions_m.rows(); ++t) {
    for (std::size_t i = 0; i < feet.size(); ++i) {
      const Foot& foot = feet[i];
      const std::vector<Eigen::Index> contacts = ColumnsOfContacts(foot);
      const Eigen::VectorXd carrying = Carrying(foot, positions_m.row(t), leg_length_m);
      Eigen::Matrix3Xd stored_points(3, stored[i].cols());
      for (Eigen::Index k = 0; k < stored_points.cols(); ++k) {
        stored_points.col(k) =
            positions_m.row(t).segment<3>(3 * foot.foot_markers[k]).cast<double>().transpose();
      }
      const Eigen::Matrix3d turn = FitRigid(leg_length_m * stored[i], stored_points,
                                            Eigen::VectorXd::Ones(stored_points.cols()))
                                       .linear();
      // The support point, on the stored foot and on the sole.
      Eigen::Vector3d on_floor = Eigen::Vector3d::Zero();
      Eigen::Vector3d of_sole = Eigen::Vector3d::Zero();
      for (std::size_t c = 0; c < contacts.size(); ++c) {
        const double share = carrying[static_cast<Eigen::Index>(c)];
        on_floor += share * stored_points.col(contacts[c]);
        on_floor.z() -= share * leg_length_m * static_cast<double>(foot.rest_heights[c]);
        of_sole += share * soles[i].col(contacts[c]);
      }
      for (Eigen::Index k = 0; k < stored_points.cols(); ++k) {
        positions_m.row(t).segment<3>(3 * foot.foot_markers[k]) =
            (on_floor + turn * (soles[i].col(k) - of_sole)).cast<float>().transpose();
      }
    }
    for (Eigen::Index m = 0; m < positions_m.cols() / 3; ++m) {
      if (!of_foot[m]) positions_m(t, 3 * m + 2) += static_cast<float>(raise);
    }
  }
}

}  // namespace

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
