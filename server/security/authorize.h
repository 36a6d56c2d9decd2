// Whether a caller may make a call. Pure; safe to call from any thread.
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "server/security/caller.h"
#include "server/security/role_table.h"

namespace motiondb::server {

// `resource` is what the rule's field names; for an operation, the database that it belongs to, or
// empty. PERMISSION_DENIED, saying what is lacking. What the caller may not touch is refused
// whether it exists or not.
absl::Status Authorize(const Caller& caller, const CallRule& rule, std::string_view resource);

const char* RoleName(storage::Role role);

}  // namespace motiondb::server
