// How annotations become changes of segments.
#include <motiondb/v1/clip.pb.h>

#include <catch2/catch.hpp>
#include <set>

#include "client/cli/annotate/segment_files.h"
#include "tests/client/random_annotations.h"

namespace motiondb::tests::segment_import_test {
namespace {

using client::Annotation;
using client::ClipIndex;
using client::ImportedSegmentId;
using client::PlanSegmentImport;
using client::SegmentImport;

v1::Clip ClipOf(const std::string& id, const std::string& file_name, double seconds) {
  v1::Clip clip;
  clip.set_name("databases/d/clips/" + id);
  clip.set_file_name(file_name);
  clip.set_duration_seconds(seconds);
  return clip;
}

Annotation LabelAt(const std::string& clip, double start, double end, const std::string& label) {
  Annotation annotation;
  annotation.clip = clip;
  annotation.track = "action";
  annotation.label = label;
  annotation.start_seconds = start;
  annotation.end_seconds = end;
  annotation.place = "a.tsv:" + std::to_string(static_cast<int>(start) + 2);
  return annotation;
}

// Applies the changes as a server does: the model of what is stored.
void ApplyTo(std::map<std::string, v1::Segment>& stored, const SegmentImport& import) {
  for (const v1::Change& change : import.changes) {
    if (change.has_create_segment()) {
      const v1::CreateSegmentRequest& create = change.create_segment();
      v1::Segment segment = create.segment();
      segment.set_name(create.parent() + "/segments/" + create.segment_id());
      REQUIRE(stored.emplace(segment.name(), segment).second);
      continue;
    }
    const v1::UpdateSegmentRequest& update = change.update_segment();
    v1::Segment& segment = stored.at(update.segment().name());
    for (const std::string& path : update.update_mask().paths()) {
      if (path == "label") segment.set_label(update.segment().label());
      if (path == "source") segment.set_source(update.segment().source());
      if (path == "confidence") segment.set_confidence(update.segment().confidence());
      if (path == "start_seconds") segment.set_start_seconds(update.segment().start_seconds());
      if (path == "end_seconds") segment.clear_end_seconds();
      if (path == "end_seconds" && update.segment().has_end_seconds()) {
        segment.set_end_seconds(update.segment().end_seconds());
      }
    }
  }
}

std::vector<v1::Segment> Values(const std::map<std::string, v1::Segment>& stored) {
  std::vector<v1::Segment> segments;
  for (const auto& [name, segment] : stored) segments.push_back(segment);
  return segments;
}

TEST_CASE("Segment import: a second import changes nothing; an export is imported unchanged",
          "[client][annotation]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::vector<v1::Clip> clips;
    for (int i = 0; i < 3; ++i) {
      clips.push_back(ClipOf("clip" + std::to_string(i), "x.bvh", kRandomClipSeconds));
    }
    const ClipIndex index(clips);
    const auto annotations = RandomAnnotations(seed, 3, 3);
    std::map<std::string, v1::Segment> stored;
    const auto first = PlanSegmentImport(index, {}, annotations);
    CAPTURE(seed, std::string(first.status().message()));
    REQUIRE(first.ok());
    CHECK(first->created == std::ssize(annotations));
    ApplyTo(stored, *first);
    CHECK(stored.size() == annotations.size());
    const auto second = PlanSegmentImport(index, Values(stored), annotations);
    REQUIRE(second.ok());
    CHECK(second->changes.empty());
    CHECK(second->unchanged == std::ssize(annotations));
    // Under other names, as made by hand.
    std::map<std::string, v1::Segment> renamed;
    for (auto [name, segment] : stored) {
      segment.set_name("databases/d/clips/" +
                       name.substr(std::string("databases/d/clips/").size(), 5) + "/segments/s" +
                       std::to_string(renamed.size()));
      renamed.emplace(segment.name(), segment);
    }
    const auto exported = client::AnnotationsOf(Values(renamed));
    const auto third = PlanSegmentImport(index, Values(renamed), exported);
    REQUIRE(third.ok());
    CHECK(third->changes.empty());
  }
}

TEST_CASE("Segment import: changes what differs", "[client][annotation]") {
  const ClipIndex index({ClipOf("a", "a.bvh", 10)});
  std::map<std::string, v1::Segment> stored;
  ApplyTo(stored,
          *PlanSegmentImport(index, {}, {LabelAt("a", 0, 1, "walk"), LabelAt("a", 1, 2, "sit")}));
  CHECK(stored.count("databases/d/clips/a/segments/action-0-1000") == 1);
  for (auto& [name, segment] : stored) {
    segment.set_etag("e");
    segment.set_source(v1::SEGMENT_SOURCE_PERSON);
  }
  const auto import = PlanSegmentImport(index, Values(stored),
                                        {LabelAt("a", 0, 1, "jog"), LabelAt("a", 1, 2, "sit")});
  REQUIRE(import.ok());
  REQUIRE(import->changes.size() == 1);  // the source of the other one is not stated
  CHECK(import->updated == 1);
  CHECK(import->places[0] == "a.tsv:2");
  const v1::UpdateSegmentRequest& update = import->changes[0].update_segment();
  CHECK(update.segment().etag() == "e");
  CHECK(update.segment().label() == "jog");
  CHECK(update.segment().source() == v1::SEGMENT_SOURCE_IMPORT);
  CHECK(update.update_mask().paths_size() == 2);
}

TEST_CASE("Segment import: ends slightly after the clip are set to its end",
          "[client][annotation]") {
  const ClipIndex index({ClipOf("a", "a.bvh", 10)});
  const auto import = PlanSegmentImport(index, {}, {LabelAt("a", 9, 10.05, "walk")});
  REQUIRE(import.ok());
  const v1::Segment& segment = import->changes[0].create_segment().segment();
  CHECK(!segment.has_end_seconds());
  CHECK(import->changes[0].create_segment().segment_id() == "action-9000-10000");
  CHECK(import->notes.size() == 1);
  CHECK(std::string(
            PlanSegmentImport(index, {}, {LabelAt("a", 9, 10.2, "walk")}).status().message()) ==
        "a.tsv:11: end: expected at most 10 s, the duration of clip 'a', found 10.2 s");
  CHECK(std::string(
            PlanSegmentImport(index, {}, {LabelAt("a", 10, 10.05, "walk")}).status().message()) ==
        "a.tsv:12: start: expected less than 10 s, the duration of clip 'a', found 10 s");
}

TEST_CASE("Segment import: annotations that overlap are refused", "[client][annotation]") {
  const ClipIndex index({ClipOf("a", "a.bvh", 10), ClipOf("b", "b.bvh", 10)});
  const auto error = [&](const std::vector<Annotation>& annotations) {
    return std::string(PlanSegmentImport(index, {}, annotations).status().message());
  };
  CHECK(error({LabelAt("a", 2, 4, "x"), LabelAt("a.bvh", 1, 2.5, "y")}) ==
        "a.tsv:4: start: overlaps a.tsv:3 on track 'action' of clip 'a'");
  Annotation other = LabelAt("a", 1, 2.5, "y");
  other.track = "carries";
  CHECK(error({LabelAt("a", 2, 4, "x"), other, LabelAt("b", 1, 2.5, "y")}).empty());
}

TEST_CASE("Segment import: clips by name or file name", "[client][annotation]") {
  const ClipIndex index({ClipOf("07_01", "walk.bvh.gz", 1), ClipOf("07_02", "same.npz", 1),
                         ClipOf("07_03", "SAME.NPZ", 1), ClipOf("07_04", "same.bvh", 1),
                         ClipOf("v1.2", "take.1.trc", 1)});
  const auto found = [&](const char* name) {
    const v1::Clip* const clip = index.Find(name);
    return clip == nullptr ? "" : clip->name().substr(std::string("databases/d/clips/").size());
  };
  CHECK(found("07_01") == "07_01");
  CHECK(found("databases/d/clips/07_01") == "07_01");
  CHECK(found("KIT/3/walk.npz") == "07_01");
  CHECK(found("walk") == "07_01");
  CHECK(found("same") == "");  // two files
  CHECK(found("07_04.bvh") == "07_04");
  CHECK(found("v1.2") == "v1.2");
  CHECK(found("take.1") == "v1.2");
  CHECK(found("") == "");
  const auto import = PlanSegmentImport(index, {}, {LabelAt("none", 0, 1, "x")});
  CHECK(import->unmatched == std::set<std::string>{"none"});
  CHECK(index.FileNameOf(*index.Find("07_01")) == "walk.bvh.gz");
  CHECK(index.FileNameOf(*index.Find("07_04")) == "07_04.bvh");
}

TEST_CASE("Segment import: names of segments fit the contract and differ", "[client][annotation]") {
  CHECK(ImportedSegmentId("action", 0, 1.5) == "action-0-1500");
  CHECK(ImportedSegmentId("action-2", 0.5, 0.75) == "action-2-500-750");
  std::set<std::string> ids;
  const std::string longest(63, 'a');
  for (int start = 0; start < 100; ++start) {
    const std::string id = ImportedSegmentId(longest, start, start + 1);
    CHECK(id.size() <= 63);
    CHECK(ids.insert(id).second);
  }
}

}  // namespace
}  // namespace motiondb::tests::segment_import_test
