#include "core/export/losses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <variant>

#include "core/format/text_scanner.h"

namespace motiondb::core {

void ReportNames(const std::vector<std::string>& before, const std::vector<std::string>& after,
                 std::vector<std::string>& losses) {
  constexpr int kShownNames = 3;
  std::string examples;
  int changed = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i] == after[i]) continue;
    if (++changed > kShownNames) continue;
    examples +=
        fmt::format("{}'{}' is '{}'", changed == 1 ? "" : ", ", Shown(before[i]), Shown(after[i]));
  }
  if (changed == 0) return;
  losses.push_back(fmt::format("names: {} of {} are changed: {}{}", changed, before.size(),
                               examples, changed > kShownNames ? ", ..." : ""));
}

void ReportJointProperties(const Motion& motion, std::string_view format,
                           std::vector<std::string>& losses) {
  const auto* const joints = std::get_if<JointMotion>(&motion);
  if (joints == nullptr) return;
  bool has_limits = false;
  bool has_axes = false;
  for (const Joint& joint : joints->skeleton->joints()) {
    const auto rotations = std::count_if(joint.dofs.begin(), joint.dofs.end(), [](const Dof& dof) {
      return dof.kind == Dof::Kind::kRotation;
    });
    has_axes = has_axes || rotations == 1 || rotations == 2;
    for (const Dof& dof : joint.dofs) {
      has_limits = has_limits || std::isfinite(dof.lower) || std::isfinite(dof.upper);
    }
  }
  if (has_limits) losses.push_back(fmt::format("joint limits: {} has none", format));
  if (has_axes) {
    losses.push_back(fmt::format("joint axes: {} turns each joint about any axis", format));
  }
}

}  // namespace motiondb::core
