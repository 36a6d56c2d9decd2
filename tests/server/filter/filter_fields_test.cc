// The meaning of each field, by examples on one clip.
#include <catch2/catch.hpp>
#include <string>

#include "server/filter/catalog.h"
#include "tests/server/filter/random_records.h"

namespace motiondb::tests {
namespace filter_fields {
namespace {

using server::Filter;
using server::FilterSubject;

// A take of 30 s: walk, then run, while the person carries a box, which a program suggested.
StoredClip Take() {
  StoredClip take;
  take.record.id = "take_7";
  take.record.subject = "07";
  take.record.title = "Morning session";
  take.record.description = "Box of 5 kg";
  take.record.file_name = "take_7.c3d";
  take.record.format = core::FileFormat::kC3d;
  take.record.frame_count = 1800;
  take.record.duration_seconds = 30;
  take.record.create_time_us = 1'777'636'800'000'000;  // 2026-05-01T12:00:00Z
  take.record.tags = {"box", "left-hand"};
  take.record.fields = {{"score", 4.0},
                        {"checked", true},
                        {"place", std::string("Hall 5")},
                        {"empty", std::string()},
                        {"number", std::string("5")},
                        {"date", storage::FieldTime{1'777'636'800'000'000}}};
  storage::SegmentRecord segment;
  segment.clip = "take_7";
  segment.id = "s1";
  segment.label = "walk";
  segment.end_seconds = 10;
  segment.author = "ann";
  take.segments.push_back(segment);
  segment.id = "s2";
  segment.label = "run";
  segment.start_seconds = 10;
  segment.end_seconds.reset();
  segment.source = storage::SegmentSource::kImport;
  take.segments.push_back(segment);
  segment.id = "s3";
  segment.track = "carries";
  segment.label = "box";
  segment.source = storage::SegmentSource::kSuggestion;
  segment.confidence = 0.7;
  segment.start_seconds = 5;
  take.segments.push_back(segment);
  return take;
}

bool Passes(const std::string& text, const StoredClip& clip) {
  const auto filter = Filter::Parse(text, FilterSubject::kClips);
  CAPTURE(text, filter.status().message());
  REQUIRE(filter.ok());
  const server::Catalog catalog = CatalogOf({{clip.record.id, clip}});
  return filter->Passes(*catalog.Find(clip.record.id));
}

TEST_CASE("Fields of clips") {
  const StoredClip take = Take();
  for (const char* text : {"name = take_7",
                           "name = take_*",
                           "subject = 07",
                           "subject:0",
                           "title:SESSION",
                           "title:\"ing s\"",
                           "title > \"Mo\"",
                           "description:kg",
                           "tags:box",
                           "tags = left-hand",
                           "tags:left*",
                           "tags:*",
                           "frames = 1800",
                           "frames > 1e3",
                           "duration = 30",
                           "duration <= 30s",
                           "format = c3d",
                           "format:c3d",
                           "file_name = *.c3d",
                           "take = \"\"",
                           "-take:*",
                           "source = suggestion",
                           "track = carries",
                           "create_time > 2026-04-30",
                           "create_time = 2026-05-01",
                           "create_time <= 2026-05-01",
                           "create_time >= 2026-05-01",
                           "create_time = \"2026-05-01T14:00:00+02:00\"",
                           "-update_time:*"}) {
    CAPTURE(text);
    CHECK(Passes(text, take));
  }
  for (const char* text :
       {"name = take", "subject = 7", "title = \"morning session\"", "tags:left", "tags = Box",
        "frames < 1800", "duration > 30s", "format != c3d", "take:*", "track = Action",
        "create_time > 2026-05-01", "create_time < 2026-05-01", "create_time != 2026-05-01"}) {
    CAPTURE(text);
    CHECK(!Passes(text, take));
  }
}

TEST_CASE("A label is one of the segments of track action") {
  const StoredClip take = Take();
  CHECK(Passes("label = walk", take));
  CHECK(Passes("label = run AND label = walk", take));
  CHECK(!Passes("label = box", take));
  CHECK(!Passes("label != walk", take));
  CHECK(Passes("label != jump", take));
  CHECK(Passes("label:*", take));
  StoredClip unlabelled = take;
  unlabelled.segments.erase(unlabelled.segments.begin(), unlabelled.segments.begin() + 2);
  CHECK(Passes("label = \"\"", unlabelled));
  CHECK(Passes("label != walk", unlabelled));
  CHECK(!Passes("label:*", unlabelled));
}

TEST_CASE("Parentheses after segment: are about one segment") {
  const StoredClip take = Take();
  CHECK(Passes("segment.label = walk AND segment.track = carries", take));
  CHECK(!Passes("segment:(label = walk AND track = carries)", take));
  CHECK(Passes("segment:(label = box track = carries)", take));
  CHECK(Passes("segment:(source = suggestion AND confidence < 0.8)", take));
  CHECK(!Passes("segment:(source = person AND confidence < 0.8)", take));
  CHECK(Passes("segment:(label = walk AND duration >= 10s)", take));
  CHECK(Passes("segment:(label != walk)", take));
  CHECK(!Passes("segment.label != walk", take));
  CHECK(Passes("segment:(walk OR jump)", take));
  CHECK(Passes("segment.end = 30", take));
  CHECK(Passes("segment.author = ann", take));
  CHECK(Passes("segment:*", take));
  StoredClip without = take;
  without.segments.clear();
  CHECK(!Passes("segment:*", without));
  CHECK(!Passes("segment.label = walk", without));
  CHECK(Passes("segment.label != walk", without));
}

TEST_CASE("Fields of the user have the type of the stored value") {
  const StoredClip take = Take();
  for (const char* text :
       {"fields.score = 4", "fields.score >= 3.5", "fields.score != 5", "fields.checked = true",
        "fields.checked:true", "fields.place = \"Hall 5\"", "fields.place:hall",
        "fields.number = 5", "fields.number = \"5\"", "fields.date = 2026-05-01",
        "fields.date = \"2026-05-01T12:00:00Z\"", "fields:score", "fields.score:*", "fields:*",
        "fields.empty:*", "-fields:missing", "fields.place < Hallway"}) {
    CAPTURE(text);
    CHECK(Passes(text, take));
  }
  // Another type, or no value: no comparison passes.
  for (const char* text : {"fields.score = \"4\"", "fields.score != high", "fields.checked != 1",
                           "fields.checked > false", "fields.date > 3", "fields.missing = 1",
                           "fields.missing != 1", "fields.missing:*"}) {
    CAPTURE(text);
    CHECK(!Passes(text, take));
  }
}

TEST_CASE("A value without a field is searched in name, label, title and tags") {
  const StoredClip take = Take();
  for (const char* text :
       {"TAKE", "walk", "session", "box", "morning walk", "\"ning ses\"", "-jump"}) {
    CAPTURE(text);
    CHECK(Passes(text, take));
  }
  for (const char* text : {"kg", "hall", "c3d", "07", "ann"}) {
    CAPTURE(text);
    CHECK(!Passes(text, take));
  }
}

TEST_CASE("Several values of one field") {
  const StoredClip take = Take();
  CHECK(Passes("subject = (06 OR 07)", take));
  CHECK(!Passes("subject = (05 OR 06)", take));
  CHECK(Passes("tags:(box AND left-hand)", take));
  CHECK(!Passes("tags:(box AND slow)", take));
  CHECK(Passes("label = (walk run -jump)", take));
}

}  // namespace
}  // namespace filter_fields
}  // namespace motiondb::tests
