#include "server/security/authorize.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

// Returns whether `resource` is the database or a part of it.
bool IsPartOf(std::string_view database, std::string_view resource) {
  const std::string name = fmt::format("databases/{}", database);
  return resource.starts_with(name) &&
         (resource.size() == name.size() || resource[name.size()] == '/');
}

bool IsWithin(const Caller& caller, const CallRule& rule, std::string_view resource) {
  switch (rule.scope) {
    case Scope::kDatabase:
    case Scope::kOperation:
      return IsPartOf(caller.database, resource);
    case Scope::kList:
      return resource.empty() || IsPartOf(caller.database, resource);
    case Scope::kServer:
      return false;
  }
  return false;
}

}  // namespace

const char* RoleName(storage::Role role) {
  switch (role) {
    case storage::Role::kReader:
      return "reader";
    case storage::Role::kIngester:
      return "ingester";
    case storage::Role::kAdmin:
      return "admin";
  }
  return "unknown";
}

absl::Status Authorize(const Caller& caller, const CallRule& rule, std::string_view resource) {
  if (caller.role < rule.min_role) {
    return core::WithReason("ROLE_REQUIRED",
                            absl::PermissionDeniedError(fmt::format(
                                "{} needs the role {}; {} has the role {}", rule.method,
                                RoleName(rule.min_role), caller.principal, RoleName(caller.role))));
  }
  if (!caller.database.empty() && !IsWithin(caller, rule, resource)) {
    return core::WithReason("DATABASE_NOT_ALLOWED", absl::PermissionDeniedError(fmt::format(
                                                        "{} is valid for databases/{} only",
                                                        caller.principal, caller.database)));
  }
  return absl::OkStatus();
}

}  // namespace motiondb::server
