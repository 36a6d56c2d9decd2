#include "client/cli/annotate/clip_edit.h"

#include <catch2/catch.hpp>

#include "client/cli/annotate/batch_edit.h"
#include "client/cli/clip_files.h"

namespace motiondb::tests::clip_edit_test {
namespace {

using Catch::Contains;
using client::ClipEdit;
using client::FieldValueText;
using client::ParseFieldOption;

v1::FieldValue ValueOf(const std::string& option) {
  const auto field = ParseFieldOption(option);
  CAPTURE(option, std::string(field.status().message()));
  REQUIRE(field.ok());
  return field->second;
}

TEST_CASE("Field option: the value determines the type", "[client][cli]") {
  CHECK(ValueOf("a=true").flag());
  CHECK(ValueOf("a=false").value_case() == v1::FieldValue::kFlag);
  CHECK(ValueOf("a=-1.5e2").number() == -150);
  CHECK(ValueOf("a=2026-01-31T10:00:00Z").time().seconds() == 1'769'853'600);
  CHECK(ValueOf("a=2026-01-31T12:00:00+02:00").time().seconds() == 1'769'853'600);
  for (const char* text : {"", "True", "1,5", "nan", "inf", "0x10", "1 ", "2026-01-31", "a=b"}) {
    CHECK(ValueOf(std::string("a=") + text).text() == text);
  }
}

TEST_CASE("Field option: a type forces the value", "[client][cli]") {
  CHECK(ValueOf("run:text=07").text() == "07");
  CHECK(ValueOf("run=07").number() == 7);
  CHECK(ValueOf("on:flag=true").flag());
  for (const char* wrong : {"a", "=1", ":text=1", "a:word=1", "a:number=x", "a:number=nan",
                            "a:flag=1", "a:time=today"}) {
    CAPTURE(wrong);
    CHECK(absl::IsInvalidArgument(ParseFieldOption(wrong).status()));
  }
}

TEST_CASE("Field value: its text gives it again", "[client][cli]") {
  for (const char* option :
       {"a=true", "a=0.1", "a=-1e-300", "a=2026-01-31T10:00:00.125Z", "a=b c"}) {
    const v1::FieldValue value = ValueOf(option);
    CHECK(ValueOf("a=" + FieldValueText(value)).SerializeAsString() == value.SerializeAsString());
  }
}

TEST_CASE("Clip edit: changes only what is given; adds to the stored tags", "[client][cli]") {
  v1::Clip stored;
  stored.set_name("databases/d/clips/c");
  stored.set_label("walk");
  stored.set_etag("e7");
  stored.add_tags("a");
  stored.add_tags("b");
  ClipEdit edit;
  CHECK(edit.empty());
  edit.title = "";
  edit.fields.insert(*ParseFieldOption("weight=70"));
  edit.removed_fields = {"old"};
  auto request = UpdateRequest(edit, stored);
  CHECK(request.clip().name() == "databases/d/clips/c");
  CHECK(request.clip().etag().empty());
  CHECK(request.update_mask().paths_size() == 3);
  CHECK(request.update_mask().paths(0) == "title");
  CHECK(request.update_mask().paths(1) == "fields.weight");
  CHECK(request.update_mask().paths(2) == "fields.old");
  CHECK(request.clip().fields().at("weight").number() == 70);
  edit = {};
  edit.tags = {"c", "a"};
  edit.removed_tags = {"b", "never"};
  request = UpdateRequest(edit, stored);
  CHECK(request.clip().etag() == "e7");
  REQUIRE(request.clip().tags_size() == 2);
  CHECK(request.clip().tags(0) == "a");
  CHECK(request.clip().tags(1) == "c");
  CHECK(request.clip().label().empty());
}

TEST_CASE("Clip list: title, description, tags and fields", "[client][cli]") {
  const auto clips =
      client::ParseClipList("a.tsv",
                            "path\tlabel\ttitle\tdescription\ttags\tfield.weight\tfield.run:text\n"
                            "a.bvh\twalk\tA walk\tLong.\tslow, outdoor,\t70\t07\n"
                            "b.bvh\twalk\t\t\t\t\t\n");
  REQUIRE(clips.ok());
  const client::ClipEntry& first = (*clips)[0];
  CHECK(first.title == "A walk");
  CHECK(first.description == "Long.");
  CHECK(first.tags == std::vector<std::string>{"slow", "outdoor"});
  CHECK(first.fields.at("weight").number() == 70);
  CHECK(first.fields.at("run").text() == "07");
  const client::ClipEntry& second = (*clips)[1];
  CHECK((second.title + second.description).empty());
  CHECK((second.tags.empty() && second.fields.empty()));
  const auto wrong = client::ParseClipList("a.tsv", "path\tlabel\tfield.w:number\na\tb\theavy\n");
  CHECK(std::string(wrong.status().message()) ==
        "a.tsv:2: field.w:number: w: expected a finite number, got heavy");
}

TEST_CASE("Batch error: names the failed change", "[client][cli]") {
  const auto failed = [](const char* message) {
    return client::FailedChangeOf(absl::InvalidArgumentError(message));
  };
  CHECK(!failed("etag is outdated"));
  CHECK(!failed("changes[x].update_clip: wrong"));
  const auto label = failed("changes[12].create_segment.segment.label: expected one line");
  REQUIRE(label);
  CHECK(label->index == 12);
  CHECK(label->detail == "label: expected one line");
  const auto overlap = failed("changes[0].update_segment: overlaps segment 'a'");
  REQUIRE(overlap);
  CHECK(overlap->detail == "overlaps segment 'a'");
  CHECK(failed("changes[3]")->detail.empty());
}

}  // namespace
}  // namespace motiondb::tests::clip_edit_test
