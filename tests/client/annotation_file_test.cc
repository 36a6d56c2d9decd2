// Properties of all formats of annotations: round trips, and hostile files.
#include <motiondb/annotation_file.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/client/random_annotations.h"

namespace motiondb::tests::annotation_file_test {
namespace {

using client::Annotation;
using client::AnnotationFormat;
using client::ReadAnnotations;
using client::WriteAnnotations;

constexpr AnnotationFormat kAll[] = {AnnotationFormat::kTsv, AnnotationFormat::kJson,
                                     AnnotationFormat::kBabel, AnnotationFormat::kTextGrid};

// What a format keeps of annotations.
std::vector<Annotation> KeptBy(AnnotationFormat format, std::vector<Annotation> annotations) {
  for (Annotation& annotation : annotations) {
    if (format != AnnotationFormat::kBabel && format != AnnotationFormat::kTextGrid) continue;
    annotation.confidence.reset();
    annotation.source.clear();
  }
  return annotations;
}

TEST_CASE("Annotations: what is written is read again", "[client][annotation]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (const AnnotationFormat format : kAll) {
      CAPTURE(seed, static_cast<int>(format));
      // BABEL has no tracks, and a TextGrid has one clip.
      const int clips = format == AnnotationFormat::kTextGrid ? 1 : 3;
      const int tracks = format == AnnotationFormat::kBabel ? 1 : 3;
      const auto annotations = RandomAnnotations(seed, clips, tracks);
      const auto bytes = WriteAnnotations(format, RandomClips(clips), annotations);
      REQUIRE(bytes.ok());
      const auto read = ReadAnnotations(format, "folder/clip0.x", *bytes);
      CAPTURE(std::string(read.status().message()));
      REQUIRE(read.ok());
      CHECK(read->notes.empty());
      CHECK(WithoutPlaces(read->annotations) == KeptBy(format, annotations));
    }
  }
}

TEST_CASE("Annotations: a file without annotations is read again", "[client][annotation]") {
  for (const AnnotationFormat format : kAll) {
    const auto bytes = WriteAnnotations(format, RandomClips(1), {});
    REQUIRE(bytes.ok());
    const auto read = ReadAnnotations(format, "clip0.x", *bytes);
    REQUIRE(read.ok());
    CHECK(read->annotations.empty());
  }
}

TEST_CASE("Annotations: no end means the end of the clip", "[client][annotation]") {
  Annotation whole;
  whole.clip = "clip0";
  whole.track = "action";
  whole.label = "walk";
  whole.start_seconds = 1;
  for (const AnnotationFormat format : kAll) {
    const auto bytes = WriteAnnotations(format, RandomClips(1), {whole});
    REQUIRE(bytes.ok());
    const auto read = ReadAnnotations(format, "clip0.x", *bytes);
    REQUIRE(read.ok());
    REQUIRE(read->annotations.size() == 1);
    const auto& end = read->annotations[0].end_seconds;
    CHECK((!end || *end == kRandomClipSeconds));
  }
}

// Every prefix, and copies with random bytes, are read or give an error that names the file.
TEST_CASE("Annotations: damaged files never crash a reader", "[client][annotation][hostile]") {
  std::mt19937 random(1);
  for (const AnnotationFormat format : kAll) {
    const auto bytes = WriteAnnotations(format, RandomClips(1), RandomAnnotations(5, 1, 2));
    REQUIRE(bytes.ok());
    const auto check = [&](const std::string& damaged) {
      const auto read = ReadAnnotations(format, "clip0.x", damaged);
      if (!read.ok()) {
        REQUIRE(absl::IsInvalidArgument(read.status()));
        REQUIRE(std::string(read.status().message()).find("clip0.x") == 0);
        return;
      }
      for (const Annotation& each : read->annotations) {
        REQUIRE(std::isfinite(each.start_seconds));
        REQUIRE((!each.end_seconds || *each.end_seconds > each.start_seconds));
        REQUIRE(!each.label.empty());
      }
    };
    for (std::size_t size = 0; size < bytes->size(); size += 7) check(bytes->substr(0, size));
    for (int i = 0; i < 2000; ++i) {
      std::string damaged = *bytes;
      for (int changes = 0; changes < 3; ++changes) {
        damaged[random() % damaged.size()] = static_cast<char>(random());
      }
      check(damaged);
    }
  }
}

TEST_CASE("Annotations: the format is known by name and content", "[client][annotation]") {
  using client::AnnotationFormatOf;
  CHECK(AnnotationFormatOf("a/b.tsv", "") == AnnotationFormat::kTsv);
  CHECK(AnnotationFormatOf("b.TEXTGRID", "") == AnnotationFormat::kTextGrid);
  CHECK(AnnotationFormatOf("b.json", " \n[]") == AnnotationFormat::kJson);
  CHECK(AnnotationFormatOf("b.json", "\xEF\xBB\xBF {}") == AnnotationFormat::kBabel);
  CHECK(!AnnotationFormatOf("b.txt", "").has_value());
}

TEST_CASE("Annotations: a format refuses what it cannot represent", "[client][annotation]") {
  Annotation annotation;
  annotation.clip = "clip0";
  annotation.track = "action";
  annotation.label = "a\tb";
  annotation.end_seconds = 2;
  const auto error = [&](AnnotationFormat format, int clips, std::vector<Annotation> annotations) {
    return std::string(
        WriteAnnotations(format, RandomClips(clips), annotations).status().message());
  };
  CHECK_THAT(error(AnnotationFormat::kTsv, 1, {annotation}), Catch::Contains("use JSON"));
  CHECK_THAT(error(AnnotationFormat::kTextGrid, 2, {annotation}),
             Catch::Contains("one clip, not 2"));
  annotation.label = "b";
  CHECK_THAT(error(AnnotationFormat::kTextGrid, 1, {annotation, annotation}),
             Catch::Contains("overlap at 0 s"));
  annotation.clip = "other";
  CHECK_THAT(error(AnnotationFormat::kJson, 1, {annotation}), Catch::Contains("'other'"));
}

}  // namespace
}  // namespace motiondb::tests::annotation_file_test
