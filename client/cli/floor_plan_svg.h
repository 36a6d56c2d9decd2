// A plan seen from above, as in the paper's Fig. 16. Pure function.
#pragma once

#include <motiondb/messages.h>

#include <string>

namespace motiondb::client {

// An SVG file that needs no other: the root's path with a circle and a heading line every 1/6 s,
// start, goal with both tolerances, obstacles with the clearance around them, and alternatives in a
// lighter colour, over axes in metres; above it the outcome and its figures, below it a legend. The
// same messages make the same bytes.
std::string FloorPlanSvg(const v1::PlanRequest& request, const v1::PlanResponse& response);

}  // namespace motiondb::client
