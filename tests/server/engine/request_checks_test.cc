// The engine checks what callers set, whichever way a request came.
#include "server/engine/request_checks.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/engine/ingest_rules.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::request_checks_test {
namespace {

std::string FieldOf(const absl::Status& status) {
  const auto payload = status.GetPayload(core::kFieldUrl);
  return payload ? std::string(*payload) : "";
}

TEST_CASE("Engine: refuses settings of a database that are out of range", "[server]") {
  TestEngine engine;
  const auto create = [&](const core::BuildSettings& settings) {
    return engine->CreateDatabase("db", settings, {server::kSourceMarkerSet, ""}).status();
  };
  CHECK(FieldOf(create({.frame_rate_hz = 0.5})) == "database.frame_rate_hz");
  CHECK(FieldOf(create({.frame_rate_hz = std::numeric_limits<double>::quiet_NaN()})) ==
        "database.frame_rate_hz");
  const absl::Status few = create({.min_frames = 1});
  CHECK(FieldOf(few) == "database.min_frames");
  CHECK(few.message() == "database.min_frames: expected 2 to 1000000, got 1");
  CHECK(create({}).ok());
  CHECK(FieldOf(server::ResolveMarkerSet("", "name \x1b").status()) == "database.marker_set_file");
  CHECK(FieldOf(server::ResolveMarkerSet("none", "").status()) == "database.marker_set");
}

TEST_CASE("Engine: refuses invalid values of an edit, and names the change in a batch",
          "[server]") {
  TestEngine engine;
  engine.Create("db");
  const auto edit = [&](storage::Change change, server::EditFields fields) {
    const std::vector<storage::Change> changes{storage::SegmentDeletion{"a", "s"},
                                               std::move(change)};
    return FieldOf(engine->Edit("db", changes, "me", {}, fields).status());
  };
  storage::ClipChange clip{.clip = "a"};
  clip.label = "";
  CHECK(edit(clip, server::EditFields::kOneChange) == "clip.label");
  CHECK(edit(clip, server::EditFields::kBatch) == "changes[1].update_clip.clip.label");
  clip.label.reset();
  clip.tags = {"z", "a", "B"};  // the index is that of the request
  CHECK(edit(clip, server::EditFields::kOneChange) == "clip.tags[2]");
  clip.tags.reset();
  clip.field["1"] = std::nullopt;
  CHECK(edit(clip, server::EditFields::kBatch) == "changes[1].update_clip.update_mask");
  storage::SegmentRecord segment{.database = "db", .clip = "a", .label = "walk"};
  segment.start_seconds = 2;
  segment.end_seconds = 1;
  CHECK(edit(storage::SegmentCreation{segment}, server::EditFields::kBatch) ==
        "changes[1].create_segment.segment.end_seconds");
  storage::SegmentChange change{.clip = "a", .id = "s"};
  change.confidence = 1.5;
  CHECK(edit(change, server::EditFields::kBatch) == "changes[1].update_segment.segment.confidence");
  const std::vector<storage::Change> many(1001, storage::SegmentDeletion{"a", "s"});
  CHECK(FieldOf(engine->Edit("db", many, "me").status()) == "changes");
}

TEST_CASE("CheckNewClip: sorts the tags, and names the field of the header", "[server]") {
  server::IngestRequest request;
  storage::ClipRecord& record = request.clip.record;
  record.file_name = "walk.bvh";
  record.tags = {"b", "a", "b"};
  REQUIRE(server::CheckNewClip(request).ok());
  CHECK(record.tags == std::vector<std::string>{"a", "b"});
  record.given.metres_per_unit = -1;
  CHECK(FieldOf(server::CheckNewClip(request)) == "header.conventions.metres_per_unit");
}

}  // namespace
}  // namespace motiondb::tests::request_checks_test
