#include "server/security/authorize.h"

#include <catch2/catch.hpp>

namespace motiondb::tests::authorize_test {
namespace {

using server::Caller;
using server::CallRule;
using server::Scope;
using storage::Role;

CallRule Rule(Role least_role, Scope scope) {
  return {"S.M", least_role, false, server::RequestClass::kLight, scope, "name"};
}

TEST_CASE("Authorize: each role may do what those before it may", "[security]") {
  for (const Role has : {Role::kReader, Role::kIngester, Role::kAdmin}) {
    for (const Role needs : {Role::kReader, Role::kIngester, Role::kAdmin}) {
      const Caller caller{"tokens/a", has};
      const absl::Status status = Authorize(caller, Rule(needs, Scope::kServer), "");
      CHECK(status.ok() == (has >= needs));
      CHECK((status.ok() || absl::IsPermissionDenied(status)));
    }
  }
  const absl::Status refused =
      Authorize({"tokens/a", Role::kReader}, Rule(Role::kAdmin, Scope::kServer), "");
  CHECK(std::string(refused.message()) == "S.M needs the role admin; tokens/a has the role reader");
}

TEST_CASE("Authorize: a caller of one database sees that alone", "[security]") {
  const Caller caller{"tokens/a", Role::kAdmin, "walks"};
  const auto may = [&](Scope scope, const char* resource) {
    return Authorize(caller, Rule(Role::kReader, scope), resource).ok();
  };
  for (const Scope scope : {Scope::kDatabase, Scope::kOperation}) {
    CHECK(may(scope, "databases/walks"));
    CHECK(may(scope, "databases/walks/clips/a"));
    CHECK(!may(scope, "databases/walks2"));
    CHECK(!may(scope, "databases/walk"));
    CHECK(!may(scope, "databases/other/clips/databases/walks"));
    CHECK(!may(scope, "walks"));
    CHECK(!may(scope, ""));
  }
  CHECK(may(Scope::kList, ""));
  CHECK(may(Scope::kList, "databases/walks"));
  CHECK(!may(Scope::kList, "databases/other"));
  CHECK(!may(Scope::kServer, ""));
  CHECK(!may(Scope::kServer, "databases/walks"));
}

}  // namespace
}  // namespace motiondb::tests::authorize_test
