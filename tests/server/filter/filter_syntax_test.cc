// The grammar: what is accepted, and how it is understood; what is rejected, and where.
#include <catch2/catch.hpp>
#include <string>

#include "core/motion/error.h"
#include "server/filter/filter.h"
#include "server/filter/syntax.h"

namespace motiondb::tests {
namespace filter_syntax {
namespace {

using server::Filter;
using server::FilterSubject;

struct Accepted {
  const char* text;
  const char* printed;
};

// Printing shows how a filter is understood.
constexpr Accepted kAccepted[] = {
    {"", ""},
    {" \t\n", ""},
    {"walk", "walk"},
    {"walk slowly", "walk AND slowly"},
    {"\"walk slowly\"", "\"walk slowly\""},
    {"'it\\'s'", "\"it's\""},
    {"label=walk", "label = walk"},
    {"label   =   'walk'", "label = \"walk\""},
    {"label != walk", "label != walk"},
    {"duration>=2.5s", "duration >= 2.5s"},
    {"duration < -1", "duration < -1"},
    {"segment.label : walk", "segment.label:walk"},
    {"tags:*", "tags:*"},
    // OR binds tighter than AND, and than the AND of a sequence.
    {"a b OR c", "a AND b OR c"},
    {"a OR b c", "a OR b AND c"},
    {"a AND b OR c AND d", "a AND b OR c AND d"},
    {"(a AND b) OR c", "(a AND b) OR c"},
    {"a AND (b OR c)", "a AND b OR c"},
    {"(a b) AND (c d)", "a AND b AND c AND d"},
    {"a OR (b OR c)", "a OR b OR c"},
    {"((((a))))", "a"},
    {"NOT a b", "NOT a AND b"},
    {"NOT (a b)", "NOT (a AND b)"},
    {"-a OR -b", "NOT a OR NOT b"},
    {"-(a OR b)", "NOT (a OR b)"},
    {"NOT (NOT a)", "NOT (NOT a)"},
    {"-label = walk", "NOT label = walk"},
    {"( a )", "a"},
    {"segment:(label = walk AND track = carries)", "segment:(label = walk AND track = carries)"},
    {"label = (walk OR run)", "label = (walk OR run)"},
    {"tags:(left -slow)", "tags:(left AND NOT slow)"},
    {"file_name = *.bvh", "file_name = *.bvh"},
    {"file_name = \"*.bvh\"", "file_name = \"*.bvh\""},
    {"title = \"a \\* b\\n\"", "title = \"a \\* b\\n\""},
    {"Nothing ANDY ORANGE", "Nothing AND ANDY AND ORANGE"},
    {"fields.score > 3", "fields.score > 3"},
    {"fields:score", "fields:score"},
    {"'label' = walk", "\"label\" = walk"},
    {"\xc3\xa4rm", "\xc3\xa4rm"},
    {"walk.bvh", "walk.bvh"},
};

TEST_CASE("Filters of the grammar are accepted and understood") {
  for (const Accepted& accepted : kAccepted) {
    CAPTURE(accepted.text);
    const auto filter = Filter::Parse(accepted.text, FilterSubject::kClips);
    CAPTURE(filter.status().message());
    REQUIRE(filter.ok());
    CHECK(filter->text() == accepted.printed);
    CHECK(filter->passes_all() == filter->text().empty());
  }
}

TEST_CASE("The examples of docs/filters.md are accepted") {
  for (const char* text :
       {"label = walk", "label = (walk OR run)", "label != walk", "label = walk*", "label = \"\"",
        "segment:(label = box AND track = carries)",
        "segment:(source = suggestion AND confidence < 0.8)",
        "segment:(label = walk AND duration >= 10s)", "segment.author = ann", "NOT segment:*",
        "subject = (\"07\" OR \"08\")", "tags:(left AND slow)",
        "create_time >= 2026-05-01 AND create_time < 2026-06-01",
        "update_time > \"2026-05-01T12:00:00+02:00\"", "format = (c3d OR trc)", "fields.score > 3",
        "fields:score", "label = walk AND subject = \"07\" OR subject = \"08\"",
        "label = \"walk\" AND subject != \"07\""}) {
    CAPTURE(text);
    CHECK(Filter::Parse(text, FilterSubject::kClips).ok());
  }
}

struct Rejected {
  const char* text;
  int byte;
  const char* message;
};

constexpr Rejected kRejected[] = {
    {"label =", 8, "expected a value after '=', got the end of the filter"},
    {"label = AND", 9, "expected a value after '=', got 'AND'"},
    {"label == walk", 8, "expected a value after '=', got '='"},
    {"= walk", 1, "expected a comparison, a value or '(', got '='"},
    {"walk AND", 9, "expected a comparison, a value or '(', got the end of the filter"},
    {"walk OR", 8, "expected a comparison, a value or '(', got the end of the filter"},
    {"NOT", 4, "expected a comparison, a value or '(', got the end of the filter"},
    {"AND walk", 1, "expected a comparison, a value or '(', got 'AND'"},
    {"walk AND OR run", 10, "got 'OR'"},
    {"NOT NOT walk", 5, "expected a comparison, a value or '(' after NOT or '-', got 'NOT'"},
    {"--walk", 2, "after NOT or '-', got '-walk'"},
    {"(walk", 6, "expected ')', got the end of the filter"},
    {"walk)", 5, "expected the end of the filter or a '(' before it, got ')'"},
    {"()", 2, "got ')'"},
    {"(a)(b)", 4, "expected a space, or the end of the filter, got '('"},
    {"NOT(a)", 4, "expected a space after NOT, got '('"},
    {"a AND(b)", 6, "expected a space after AND, got '('"},
    {"a OR(b)", 5, "expected a space after OR, got '('"},
    {"\"walk", 6, "expected \" to end the text that begins at byte 1, got the end of the filter"},
    {"'\\x'", 3, "after '\\', got 'x'"},
    {"\"a\"\"b\"", 4, "expected a space, or the end of the filter, got '\"'"},
    {"file_name = walk.", 18, "a name after '.'"},
    {"file_name = *..bvh", 15, "a name after '.'"},
    {"create_time > 2026-05-01T12:00:00Z", 28,
     "expected a space after the value; a value with special characters needs quotes, got ':'"},
    {"near(label, walk)", 1, "got the function near(); filters have no functions"},
    {"label = lower(walk)", 9, "got the function lower(); filters have no functions"},
    {"a, b", 2, "expected a space, or the end of the filter, got ','"},
    {"walk and run", 6, "expected AND or \"and\" with quotes, got 'and'"},
    {"a && b", 3, "expected AND"},
    {"\xff", 1, "expected UTF-8"},
    // Fields and types.
    {"lable = walk", 1, "expected a field of clips, got 'lable'; did you mean 'label'?"},
    {"a AND subjct = x", 7, "did you mean 'subject'?"},
    {"confidence > 0.5", 1, "did you mean 'segment.confidence'?"},
    {"duration_seconds > 5", 1, "did you mean 'duration'?"},
    {"clip.label = walk", 1, "expected a field of clips, got 'clip.label'; did you mean 'label'?"},
    {"xyzzy = 1", 1, "expected a field of clips, got 'xyzzy'"},
    {"segment.lable = walk", 1, "did you mean 'segment.label'?"},
    {"duration > long", 12, "expected seconds as 2.5s or 2.5 for 'duration', got 'long'"},
    {"duration > 5m", 12, "got '5m'"},
    {"frames = 1e400", 10, "expected a number for 'frames', got '1e400'"},
    {"frames = nan", 10, "expected a number"},
    {"create_time > yesterday", 15, "expected a date as 2026-05-01 or a time as"},
    {"create_time > 2026-02-30", 15, "got '2026-02-30'"},
    {"format = bhv", 10,
     "expected one of bvh, amc, trc, c3d, csv, npz, fbx, gltf, dae for "
     "'format', got 'bhv'"},
    {"source = persons", 10, "did you mean 'person'?"},
    {"format < bvh", 1, "expected =, != or ':' after 'format', got '<'"},
    {"tags > left", 1, "expected =, != or ':' after 'tags', got '>'"},
    {"description = walk", 1, "expected ':' after 'description', got '='"},
    {"segment = walk", 1, "expected segment:* or segment:(...)"},
    {"fields = 3", 1, "expected fields.NAME, fields:NAME or fields:*"},
    {"fields.Score = 3", 1, "expected a name of a-z, 0-9 and '_' after 'fields.', got 'Score'"},
    {"name = databases/db/clips/a", 8, "expected the last part of the clip's name for 'name'"},
    {"label != (walk OR run)", 10, "expected one value after '!='"},
    {"label = (walk OR title = run)", 18, "expected only values between the parentheses"},
    {"segment:(subject = x)", 10, "expected a field of segments, got 'subject'"},
    {"segment:(clip.subject = x)", 10, "expected a field of segments"},
    {"segment:(segment:*)", 10, "expected a field of segments"},
};

TEST_CASE("Other filters are rejected, with byte, expectation and content") {
  for (const Rejected& rejected : kRejected) {
    CAPTURE(rejected.text);
    const auto filter = Filter::Parse(rejected.text, FilterSubject::kClips);
    REQUIRE(!filter.ok());
    CHECK(absl::IsInvalidArgument(filter.status()));
    CHECK(filter.status().GetPayload(core::kFieldUrl) == "filter");
    const std::string message(filter.status().message());
    CHECK_THAT(message, Catch::StartsWith("filter: byte " + std::to_string(rejected.byte) + ": "));
    CHECK_THAT(message, Catch::Contains(rejected.message));
  }
}

TEST_CASE("The fields of segments are others than those of clips") {
  for (const char* text : {"clip = a", "clip.subject = x", "start > 2s", "clip.segment.label = x",
                           "clip.segment:(label = x)", "clip.fields.score > 1", "walk"}) {
    CAPTURE(text);
    CHECK(Filter::Parse(text, FilterSubject::kSegments).ok());
  }
  for (const char* text : {"subject = x", "segment:*", "clip.clip = a", "name = 'databases/d'",
                           "clip:*", "clip.start = 1"}) {
    CAPTURE(text);
    const auto filter = Filter::Parse(text, FilterSubject::kSegments);
    CHECK(filter.ok() == (std::string(text) == "clip:*" || std::string(text).starts_with("name")));
  }
  const auto filter = Filter::Parse("subject = x", FilterSubject::kSegments);
  CHECK_THAT(std::string(filter.status().message()), Catch::Contains("'clip.subject'"));
}

TEST_CASE("Size and depth of filters are limited") {
  const std::string longest = std::string(server::kMaxFilterBytes, 'a');
  CHECK(Filter::Parse(longest, FilterSubject::kClips).ok());
  const auto too_long = Filter::Parse(longest + "a", FilterSubject::kClips);
  CHECK(std::string(too_long.status().message()) ==
        "filter: byte 4097: expected at most 4096 bytes, got 4097");

  const auto nested = [](int depth) {
    return std::string(static_cast<std::size_t>(depth), '(') + "a" +
           std::string(static_cast<std::size_t>(depth), ')');
  };
  CHECK(Filter::Parse(nested(server::kMaxFilterDepth), FilterSubject::kClips).ok());
  const auto too_deep = Filter::Parse(nested(server::kMaxFilterDepth + 1), FilterSubject::kClips);
  CHECK(std::string(too_deep.status().message()) ==
        "filter: byte 33: expected at most 32 levels of parentheses");
  CHECK(!Filter::Parse(std::string(4096, '('), FilterSubject::kClips).ok());
}

}  // namespace
}  // namespace filter_syntax
}  // namespace motiondb::tests
