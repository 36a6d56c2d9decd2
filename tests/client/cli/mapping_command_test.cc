#include <motiondb/v1/marker_set.pb.h>

#include <catch2/catch.hpp>

#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::mapping_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

v1::GetMarkerSetResponse SomeSet() {
  v1::GetMarkerSetResponse response;
  v1::MarkerSet& set = *response.mutable_marker_set();
  set.set_name("feet");
  set.set_text("motiondb-marker-set 1\nname feet\nmarker L\nmarker R\nhips L R\n");
  for (const char* name : {"one", "two"}) {
    v1::Mapping& mapping = *set.add_mappings();
    mapping.set_name(name);
    for (const char* point : {"a", "b", "c", "d", "e"}) mapping.add_signature(point);
    mapping.set_text(std::string("mapping ") + name + "\nL = a\nR = b\n");
  }
  return response;
}

TEST_CASE("motiondb mapping add: sends the file and says what to do next", "[client][cli]") {
  FakeServer server;
  v1::AddMappingsResponse added;
  *added.add_mappings() = SomeSet().marker_set().mappings(0);
  server.Answer("AddMappings", added);
  const TemporaryFolder folder;
  const std::string file = folder.Write("any name.txt", "the mapping").string();
  const auto result = RunMotiondb(server.address(), {"mapping", "add", "walks", file});
  CHECK(result.err.empty());
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out, StartsWith("added mapping one for 5 joint or marker names\n") &&
                             Contains("motiondb reprocess walks"));
  const auto requests = server.Requests<v1::AddMappingsRequest>("AddMappings");
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].database() == "databases/walks");
  CHECK(requests[0].mapping_file() == "the mapping");
  CHECK_THAT(RunMotiondb(server.address(), {"mapping", "add", "walks", "none.txt"}).err,
             Contains("none.txt"));
}

TEST_CASE("motiondb mapping list and show", "[client][cli]") {
  FakeServer server;
  server.Answer("GetMarkerSet", SomeSet());
  const auto list = RunMotiondb(server.address(), {"mapping", "list", "walks"});
  CHECK(list.exit_code == 0);
  CHECK_THAT(list.out, Contains("one") && Contains("a b c d ...") && Contains("two"));
  const auto show = RunMotiondb(server.address(), {"mapping", "show", "walks", "two"});
  CHECK(show.out == "motiondb-marker-set 1\nmapping two\nL = a\nR = b\n");
  const auto none = RunMotiondb(server.address(), {"mapping", "show", "walks", "three"});
  CHECK(none.exit_code == 1);
  CHECK_THAT(none.err, Contains("'feet' of databases/walks has no mapping 'three'"));
  const auto requests = server.Requests<v1::GetMarkerSetRequest>("GetMarkerSet");
  CHECK(requests.front().database() == "databases/walks");
}

TEST_CASE("motiondb mapping delete", "[client][cli]") {
  FakeServer server;
  server.Answer("DeleteMapping", v1::DeleteMappingResponse());
  const auto result = RunMotiondb(server.address(), {"mapping", "delete", "walks", "one"});
  CHECK_THAT(result.out, StartsWith("deleted mapping one"));
  const auto requests = server.Requests<v1::DeleteMappingRequest>("DeleteMapping");
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].database() == "databases/walks");
  CHECK(requests[0].mapping() == "one");
}

TEST_CASE("motiondb marker-set show: the built-in set, or that of a database", "[client][cli]") {
  FakeServer server;
  server.Answer("GetMarkerSet", SomeSet());
  const auto result = RunMotiondb(server.address(), {"marker-set", "show", "standard34"});
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out,
             StartsWith("motiondb-marker-set 1\nname feet\n") && Contains("\nmapping two\n"));
  REQUIRE(RunMotiondb(server.address(), {"marker-set", "show", "--database", "walks"}).exit_code ==
          0);
  const auto requests = server.Requests<v1::GetMarkerSetRequest>("GetMarkerSet");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].database().empty());
  CHECK(requests[1].database() == "databases/walks");
  CHECK(RunMotiondb(server.address(), {"marker-set", "show"}).exit_code == 2);
  CHECK(RunMotiondb(server.address(), {"marker-set", "show", "feet"}).exit_code == 2);
}

}  // namespace
}  // namespace motiondb::tests::mapping_command_test
