// What a file cannot express, as notes for the user.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/motion/motion.h"

namespace motiondb::core {

// Adds a note if names differ in the file: their number and the first of them. REQUIRES: equal
// sizes. O(names).
void ReportNames(const std::vector<std::string>& before, const std::vector<std::string>& after,
                 std::vector<std::string>& losses);

// Adds notes if joints have limits, or axes that they turn about, in a format that keeps only their
// rotations. O(joints).
void ReportJointProperties(const Motion& motion, std::string_view format,
                           std::vector<std::string>& losses);

}  // namespace motiondb::core
