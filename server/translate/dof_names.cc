#include "server/translate/dof_names.h"

#include <fmt/format.h>

#include <map>

namespace motiondb::server {
namespace {

// "tx", "rz": what the degree of freedom does, and along or about which axis.
std::string Movement(const core::Dof& dof) {
  Eigen::Index axis = 0;
  dof.axis.cwiseAbs().maxCoeff(&axis);
  return {dof.kind == core::Dof::Kind::kTranslation ? 't' : 'r', "xyz"[axis]};
}

}  // namespace

std::vector<std::string> DofNames(const core::Skeleton& skeleton) {
  std::vector<std::string> names;
  for (const core::Joint& joint : skeleton.joints()) {
    if (joint.dofs.size() == 1) {
      names.push_back(joint.name);
      continue;
    }
    std::map<std::string, int> seen;
    for (const core::Dof& dof : joint.dofs) {
      const std::string movement = Movement(dof);
      const int count = ++seen[movement];
      names.push_back(fmt::format("{}.{}", joint.name, movement));
      if (count > 1) names.back() += std::to_string(count);
    }
  }
  return names;
}

}  // namespace motiondb::server
