// A plan as a server returns it: a quarter of a circle to the left.
#pragma once

#include <motiondb/v1/plan.pb.h>

#include <cmath>
#include <numbers>

namespace motiondb::tests {

// Returns 61 frames at 30 Hz from the origin to (radius, radius), with a final heading of pi / 2.
inline v1::PlannedMotion QuarterCircle(double radius) {
  v1::PlannedMotion motion;
  motion.set_outcome(v1::PLAN_OUTCOME_EXACT);
  motion.set_frame_rate_hz(30);
  motion.set_frame_count(61);
  for (int i = 0; i <= 60; ++i) {
    const double angle = std::numbers::pi / 2 * i / 60;
    v1::FloorPose& pose = *motion.add_root();
    pose.set_x_m(radius * std::sin(angle));
    pose.set_y_m(radius * (1 - std::cos(angle)));
    pose.set_heading_rad(angle);
  }
  v1::PlayedSegment& segment = *motion.add_segments();
  segment.set_clip("databases/walks/clips/07_01");
  segment.set_start_seconds(0.5);
  segment.set_end_seconds(2.5);
  v1::PlanQuality& quality = *motion.mutable_quality();
  quality.set_position_error_m(0.021);
  quality.set_heading_error_rad(0.0123);
  quality.set_length_m(std::numbers::pi / 2 * radius);
  quality.set_duration_seconds(2);
  quality.set_foot_slide_m_per_s(0.015);
  quality.set_smallest_clearance_m(0.42);
  return motion;
}

inline v1::PlanResponse QuarterCirclePlan() {
  v1::PlanResponse response;
  response.set_outcome(v1::PLAN_OUTCOME_EXACT);
  *response.mutable_motion() = QuarterCircle(1);
  response.set_leg_length_m(0.85);
  response.mutable_effort()->set_expansions(1234);
  response.mutable_effort()->set_improvements(1);
  response.mutable_effort()->set_search_seconds(0.0456);
  response.mutable_effort()->set_total_seconds(0.3);
  return response;
}

inline v1::PlanRequest QuarterCircleRequest() {
  v1::PlanRequest request;
  request.set_database("databases/walks");
  request.mutable_goal()->set_x_m(1);
  request.mutable_goal()->set_y_m(1);
  request.mutable_goal()->set_heading_rad(std::numbers::pi / 2);
  return request;
}

}  // namespace motiondb::tests
