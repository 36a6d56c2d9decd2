// Praat TextGrid: the forms and encodings that Praat writes.
#include <motiondb/annotation_file.h>

#include <catch2/catch.hpp>

#include "client/annotation/text_grid_tokens.h"

namespace motiondb::tests::text_grid_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;
using client::Annotation;
using client::AnnotationFile;
using client::AnnotationFormat;
using client::ReadAnnotations;

// As Praat's "Save as text file".
constexpr char kLong[] = R"(File type = "ooTextFile"
Object class = "TextGrid"

xmin = 0 
xmax = 2.3 
tiers? <exists> 
size = 3 
item []: 
    item [1]:
        class = "IntervalTier" 
        name = "Mary Ann" 
        xmin = 0 
        xmax = 2.3 
        intervals: size = 2 
        intervals [1]:
            xmin = 0 
            xmax = 1.5 
            text = "says ""hi""" 
        intervals [2]:
            xmin = 1.5 
            xmax = 2.3 
            text = "" 
    item [2]:
        class = "TextTier" 
        name = "bell" 
        xmin = 0 
        xmax = 2.3 
        points: size = 1 
        points [1]:
            number = 1 
            mark = "ding" 
    item [3]:
        class = "IntervalTier" 
        name = "action" 
        xmin = 0 
        xmax = 2.3 
        intervals: size = 1 
        intervals [1]:
            xmin = 0.25 
            xmax = 2.3 
            text = " walk " 
)";

// As Praat's "Save as short text file".
constexpr char kShort[] = R"(File type = "ooTextFile"
Object class = "TextGrid"

0
2.3
<exists>
3
"IntervalTier"
"Mary Ann"
0
2.3
2
0
1.5
"says ""hi"""
1.5
2.3
""
"TextTier"
"bell"
0
2.3
1
1
"ding"
"IntervalTier"
"action"
0
2.3
1
0.25
2.3
" walk "
)";

// `text` is ASCII.
std::string AsUtf16(const std::string& text, bool is_big_endian) {
  std::string bytes = is_big_endian ? "\xFE\xFF" : "\xFF\xFE";
  for (const char c : text) {
    if (is_big_endian) bytes += '\0';
    bytes += c;
    if (!is_big_endian) bytes += '\0';
  }
  return bytes;
}

AnnotationFile Read(const std::string& bytes) {
  auto file = ReadAnnotations(AnnotationFormat::kTextGrid, "grids/07_01.TextGrid", bytes);
  CAPTURE(std::string(file.status().message()));
  REQUIRE(file.ok());
  for (Annotation& each : file->annotations) each.place.clear();
  return *std::move(file);
}

std::string ErrorOf(const std::string& bytes) {
  return std::string(
      ReadAnnotations(AnnotationFormat::kTextGrid, "a.TextGrid", bytes).status().message());
}

TEST_CASE("TextGrid: interval tiers are tracks; points are noted", "[client][annotation]") {
  const AnnotationFile file = Read(kLong);
  REQUIRE(file.annotations.size() == 2);
  CHECK(file.annotations[0].clip == "07_01");
  CHECK(file.annotations[0].track == "mary_ann");
  CHECK(file.annotations[0].label == "says \"hi\"");
  CHECK(file.annotations[0].end_seconds == 1.5);
  CHECK(file.annotations[1].track == "action");
  CHECK(file.annotations[1].label == "walk");
  CHECK(file.annotations[1].start_seconds == 0.25);
  REQUIRE(file.notes.size() == 2);
  CHECK_THAT(file.notes[0], Contains("tier 'Mary Ann' is track 'mary_ann'"));
  CHECK_THAT(file.notes[1], Contains("tier 'bell' has points, which are not imported: 1"));
  const auto placed = ReadAnnotations(AnnotationFormat::kTextGrid, "a.TextGrid", kLong);
  CHECK(placed->annotations[0].place == "a.TextGrid:16");
}

TEST_CASE("TextGrid: all forms and encodings give the same", "[client][annotation]") {
  const std::vector<Annotation> expected = Read(kLong).annotations;
  std::string crlf;
  for (const char c : std::string(kLong)) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  for (const std::string& bytes :
       {std::string(kShort), crlf, "\xEF\xBB\xBF" + std::string(kLong), AsUtf16(kLong, true),
        AsUtf16(kShort, false), AsUtf16(crlf, false)}) {
    CHECK(Read(bytes).annotations == expected);
  }
}

TEST_CASE("TextGrid: UTF-16 with surrogate pairs", "[client][annotation]") {
  const auto decoded = client::DecodePraatText("a", std::string("\xFE\xFF\xD8\x3D\xDE\xB6\0e", 8));
  REQUIRE(decoded.ok());
  CHECK(*decoded ==
        "\xF0\x9F\x9A\xB6"
        "e");
  for (const std::string& wrong :
       {std::string("\xFE\xFF\xD8\x3D"), std::string("\xFE\xFF\xDE\xB6"),
        std::string("\xFE\xFF\0", 3), std::string("\xFE\xFF\xD8\x3D\xD8\x3D", 6)}) {
    CHECK_THAT(std::string(client::DecodePraatText("a", wrong).status().message()),
               StartsWith("a: expected UTF-16"));
  }
  CHECK_THAT(ErrorOf("\xE9t\xE9"), Contains("expected UTF-8, or UTF-16"));
}

TEST_CASE("TextGrid: tiers of the same name are different tracks", "[client][annotation]") {
  std::string text = kLong;
  text.replace(text.find("Mary Ann"), 8, "action");
  const AnnotationFile file = Read(text);
  CHECK(file.annotations[0].track == "action");
  CHECK(file.annotations[1].track == "action-2");
}

TEST_CASE("TextGrid: errors name line and field", "[client][annotation]") {
  const auto replaced = [](const std::string& from, const std::string& to) {
    std::string text = kLong;
    text.replace(text.find(from), from.size(), to);
    return ErrorOf(text);
  };
  CHECK(ErrorOf("") ==
        "a.TextGrid:1: file type: expected a text in quotes, found the end of the file");
  CHECK_THAT(replaced("\"TextGrid\"", "\"PitchTier\""),
             StartsWith("a.TextGrid:2: expected a text"));
  CHECK(replaced("xmax = 1.5", "xmax = soon") ==
        "a.TextGrid:18: xmax: expected a number, found a text");
  CHECK(replaced("xmin = 1.5", "xmin = 1.4") ==
        "a.TextGrid:20: xmin: expected at least 1.5, the end of the interval before, found 1.4");
  CHECK(replaced("\"IntervalTier\"", "\"Sound\"") ==
        "a.TextGrid:10: class of the tier: expected IntervalTier or TextTier, found 'Sound'");
  CHECK_THAT(replaced("\" walk \"", "\" walk"), Contains("found a text without closing quote"));
  CHECK_THAT(replaced("xmax = 1.5", "xmax = 0"), Contains("end: expected seconds after the start"));
  CHECK_THAT(replaced("size = 3", "size = 1000000000"), Contains("at most 1000 tiers"));
  CHECK_THAT(replaced("intervals: size = 1 ", "intervals: size = 1e18"),
             Contains("xmin: expected a number, found the end of the file"));
  CHECK_THAT(replaced("says", "a\nb"), Contains("label: expected one line"));
}

}  // namespace
}  // namespace motiondb::tests::text_grid_test
