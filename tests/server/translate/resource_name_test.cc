#include "server/translate/resource_name.h"

#include <catch2/catch.hpp>

#include "server/engine/ingest_rules.h"

namespace motiondb::server::resource_name_test {
namespace {

TEST_CASE("ResourceName: made names can be parsed", "[server][translate]") {
  CHECK(*ParseDatabaseName("name", DatabaseName("db")) == "db");
  CHECK(ParseClipName("name", ClipName("db", "02_01"))->database == "db");
  CHECK(ParseClipName("name", ClipName("db", "02_01"))->id == "02_01");
  CHECK(ParseSkeletonName("name", SkeletonName("db", "Hips"))->id == "Hips");
  CHECK(ParseModelName("name", ModelName("db", 12))->version == 12);
  CHECK(ParseModelName("name", "databases/db/models/current")->version == 0);
  CHECK(*ParseOperationName("name", OperationName("17-3")) == "17-3");
}

TEST_CASE("ResourceName: invalid names are refused with the expected form", "[server][translate]") {
  for (const char* name : {"", "db", "databases", "databases/", "/db", "clips/a", "databases/a/",
                           "databases/a/b", "Databases/a", "databases/a/clips/c"}) {
    const auto parsed = ParseDatabaseName("name", name);
    CHECK(absl::IsInvalidArgument(parsed.status()));
    CHECK(std::string(parsed.status().message()).find("expected databases/{database}") !=
          std::string::npos);
  }
  for (const char* name : {"databases/a", "databases/a/clips", "databases/a/clips/",
                           "databases//clips/c", "databases/a/skeletons/c"}) {
    CHECK(!ParseClipName("name", name).ok());
  }
  for (const char* version : {"0", "-1", "1.5", "x", "1x", "99999999999"}) {
    CHECK(!ParseModelName("name", std::string("databases/a/models/") + version).ok());
  }
}

TEST_CASE("ResourceName: ids of new databases and clips", "[server][translate]") {
  for (const std::string id : {"a", "0", "walks-2_x", "abc"}) CHECK(CheckDatabaseId("f", id).ok());
  CHECK(CheckDatabaseId("f", std::string(63, 'a')).ok());
  for (const std::string id : {"", "-a", "_a", "A", "a b", "a/b", "a.b", "\xc3\xa4"}) {
    CHECK(!CheckDatabaseId("f", id).ok());
  }
  CHECK(!CheckDatabaseId("f", std::string(64, 'a')).ok());
  for (const std::string id : {"a", "A.b-c_1", "."}) CHECK(CheckClipId("f", id).ok());
  for (const std::string id : {"", "a/b", "a b"}) CHECK(!CheckClipId("f", id).ok());
  CHECK(!CheckClipId("f", std::string(128, 'a')).ok());
}

}  // namespace
}  // namespace motiondb::server::resource_name_test
