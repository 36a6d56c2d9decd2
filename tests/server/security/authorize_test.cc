#include "server/security/authorize.h"

#include <catch2/catch.hpp>

namespace motiondb::tests::authorize_test {
namespace {

using server::Caller;
using server::CallRule;
using server::Scope;
using storage::Role;

CallRule Rule(Role min_role, Scope scope) {
  return {"S.M", min_role, false, server::RequestClass::kLight, scope, "name"};
}

TEST_CASE("Authorize: each role includes the lower roles", "[security]") {
  for (const Role role : {Role::kReader, Role::kIngester, Role::kAdmin}) {
    for (const Role required : {Role::kReader, Role::kIngester, Role::kAdmin}) {
      const Caller caller{"tokens/a", role};
      const absl::Status status = Authorize(caller, Rule(required, Scope::kServer), "");
      CHECK(status.ok() == (role >= required));
      CHECK((status.ok() || absl::IsPermissionDenied(status)));
    }
  }
  const absl::Status refused =
      Authorize({"tokens/a", Role::kReader}, Rule(Role::kAdmin, Scope::kServer), "");
  CHECK(std::string(refused.message()) == "S.M needs the role admin; tokens/a has the role reader");
}

TEST_CASE("Authorize: a caller of one database sees only that database", "[security]") {
  const Caller caller{"tokens/a", Role::kAdmin, "walks"};
  const auto is_allowed = [&](Scope scope, const char* resource) {
    return Authorize(caller, Rule(Role::kReader, scope), resource).ok();
  };
  for (const Scope scope : {Scope::kDatabase, Scope::kOperation}) {
    CHECK(is_allowed(scope, "databases/walks"));
    CHECK(is_allowed(scope, "databases/walks/clips/a"));
    CHECK(!is_allowed(scope, "databases/walks2"));
    CHECK(!is_allowed(scope, "databases/walk"));
    CHECK(!is_allowed(scope, "databases/other/clips/databases/walks"));
    CHECK(!is_allowed(scope, "walks"));
    CHECK(!is_allowed(scope, ""));
  }
  CHECK(is_allowed(Scope::kList, ""));
  CHECK(is_allowed(Scope::kList, "databases/walks"));
  CHECK(!is_allowed(Scope::kList, "databases/other"));
  CHECK(!is_allowed(Scope::kServer, ""));
  CHECK(!is_allowed(Scope::kServer, "databases/walks"));
}

}  // namespace
}  // namespace motiondb::tests::authorize_test
