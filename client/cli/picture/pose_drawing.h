// Poses in a picture: markers, bones and velocities.
#pragma once

#include <motiondb/messages.h>

#include <string>
#include <utility>
#include <vector>

#include "client/cli/plot/canvas.h"

namespace motiondb::v1 {
class Figure;
}  // namespace motiondb::v1

namespace motiondb::client {

// Positions (x, y, z) of markers, m, z up; NaN: missing.
using Pose = std::vector<float>;

// Pairs of indices of markers.
using Bones = std::vector<std::pair<int, int>>;

// Returns the bones of the markers; omits those of markers that do not exist.
Bones MarkerBones(const v1::Figure& figure);

// A direction of view, and a scale.
struct PoseView {
  double right_x = 0, right_y = 1;  // direction in the world to the right of the picture, length 1
  double low_z = 0;                 // m, at the lower edge
  double pixels_per_m = 1;
};

// Returns a view of the poses, each in a rectangle of this size. The reference view shows poses
// that look in the direction of x, from ahead and their left. The widest one shows poses of a
// motion from the side where they extend most.
PoseView ReferenceView(const std::vector<Pose>& poses, double width, double height);
PoseView WidestView(const std::vector<Pose>& poses, double width, double height);

// Returns the mean x and y of the markers (m).
std::pair<double, double> MiddleOf(const Pose& pose);

// Where and how to draw a pose.
struct PoseStyle {
  std::string bone = "bone";
  std::string marker = "marker";
  double marker_radius = 2.2;  // pixels
};

// Draws a pose so that the point `middle` (m) of the floor is at `foot` (pixels).
void DrawPose(Canvas& canvas, const Pose& pose, const Bones& bones, const PoseView& view,
              std::pair<double, double> middle, Point foot, const PoseStyle& style);

// Draws the way of each marker in 0.1 s. `velocities`: m/s.
void DrawVelocities(Canvas& canvas, const Pose& pose, const Pose& velocities, const PoseView& view,
                    std::pair<double, double> middle, Point foot);

// Adds the styles of poses.
void AddPoseStyles(Canvas& canvas);

}  // namespace motiondb::client
