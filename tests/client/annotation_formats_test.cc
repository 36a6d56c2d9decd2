// Examples and errors of TSV, JSON and BABEL.
#include <motiondb/annotation_file.h>

#include <catch2/catch.hpp>

namespace motiondb::tests::annotation_formats_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;
using client::Annotation;
using client::AnnotationFormat;
using client::ReadAnnotations;

std::vector<Annotation> Read(AnnotationFormat format, const std::string& bytes) {
  const auto file = ReadAnnotations(format, "a.x", bytes, "main");
  CAPTURE(std::string(file.status().message()));
  REQUIRE(file.ok());
  return file->annotations;
}

std::string ErrorOf(AnnotationFormat format, const std::string& bytes) {
  return std::string(ReadAnnotations(format, "a.x", bytes, "main").status().message());
}

TEST_CASE("Annotation TSV: columns in any order; others are ignored", "[client][annotation]") {
  const auto read = Read(AnnotationFormat::kTsv,
                         "\xEF\xBB\xBFlabel\tclip\tstart\tnote\ttrack\r\n# held back\r\n\r\n"
                         "walk\t07_01\t0.5\tx\t\r\nbox\t07_02.bvh\t1e-1\t\tcarries\r\n");
  REQUIRE(read.size() == 2);
  CHECK(read[0].clip == "07_01");
  CHECK(read[0].label == "walk");
  CHECK(read[0].start_seconds == 0.5);
  CHECK(!read[0].end_seconds);
  CHECK(read[0].track == "main");
  CHECK(read[0].place == "a.x:4");
  CHECK(read[1].track == "carries");
  CHECK(read[1].start_seconds == 0.1);
}

TEST_CASE("Annotation TSV: errors name line and field", "[client][annotation]") {
  const std::string header = "clip\tstart\tend\tlabel\ttrack\tconfidence\tsource\n";
  const auto error = [&](const std::string& line) {
    return ErrorOf(AnnotationFormat::kTsv, header + line + "\n");
  };
  CHECK(ErrorOf(AnnotationFormat::kTsv, "") ==
        "a.x:1: expected a header line with \"clip\", \"start\" and \"label\", found nothing");
  CHECK_THAT(ErrorOf(AnnotationFormat::kTsv, "clip\tlabel\n"), Contains("found no \"start\""));
  CHECK(ErrorOf(AnnotationFormat::kTsv, "clip\tclip\n") ==
        "a.x:1: expected the column \"clip\" once");
  CHECK(error("a\t0") == "a.x:2: expected 7 cells, separated by tabs, found 2");
  CHECK(error("a\tsoon\t1\tw\t\t\t") == "a.x:2: start: expected a number, found 'soon'");
  CHECK(error("a\t\t1\tw\t\t\t") == "a.x:2: start: expected a number, found nothing");
  CHECK(error("a\t-1\t1\tw\t\t\t") == "a.x:2: start: expected seconds, at least 0, found -1");
  CHECK(error("a\t2\t1\tw\t\t\t") == "a.x:2: end: expected seconds after the start, 2, found 1");
  CHECK(error("a\tnan\t1\tw\t\t\t") == "a.x:2: start: expected a number, found 'nan'");
  CHECK(error("a\t0\tinf\tw\t\t\t") == "a.x:2: end: expected a number, found 'inf'");
  CHECK(error("a\t0\t1\t\t\t\t") == "a.x:2: label: expected a label, found nothing");
  CHECK(error("\t0\t1\tw\t\t\t") == "a.x:2: clip: expected a clip, found nothing");
  CHECK_THAT(error("a\t0\t1\tw\tUp\t\t"), StartsWith("a.x:2: track: expected 1 to 63 of"));
  CHECK(error("a\t0\t1\tw\t\t2\t") == "a.x:2: confidence: expected 0 to 1, found 2");
  CHECK_THAT(error("a\t0\t1\tw\t\t\tme"), StartsWith("a.x:2: source: expected person, import or"));
  CHECK(error("a\t0\t1\tw\xFF\t\t\t") == "a.x:2: label: expected UTF-8 text");
}

TEST_CASE("Annotation JSON: an array of objects", "[client][annotation]") {
  const auto read =
      Read(AnnotationFormat::kJson,
           R"([{"clip": "a", "start": 0, "end": 1.5, "label": "walk", "confidence": null},
               {"clip": "b", "start": 2, "label": "box", "track": "carries", "source": "person"}])");
  REQUIRE(read.size() == 2);
  CHECK(read[0].end_seconds == 1.5);
  CHECK(!read[0].confidence);
  CHECK(read[0].track == "main");
  CHECK(read[1].source == "person");
  CHECK(read[1].place == "a.x: [1]");
}

TEST_CASE("Annotation JSON: errors name line or path", "[client][annotation]") {
  const auto error = [](const std::string& text) { return ErrorOf(AnnotationFormat::kJson, text); };
  CHECK_THAT(error("[\n{\"clip\" 1}]"), StartsWith("a.x:2: expected JSON"));
  CHECK(error("{}") == "a.x: expected an array of annotations, found object");
  CHECK(error("[1]") == "a.x: [0]: expected an object, found number");
  CHECK(error(R"([{"clip": "a", "start": "0", "label": "w"}])") ==
        "a.x: [0]: start: expected a finite number, found string");
  CHECK(error(R"([{"clip": "a", "label": "w"}])") ==
        "a.x: [0]: start: expected a number, found nothing");
  CHECK(error(R"([{"clip": 1, "start": 0, "label": "w"}])") ==
        "a.x: [0]: clip: expected text, found number");
  CHECK_THAT(error(R"([{"clip": "a", "start": 1e999, "label": "w"}])"), Contains("too large"));
  CHECK_THAT(error(std::string(1'000'000, '[')), Contains("at most 32 levels"));
  CHECK_THAT(error("[" + std::string(9'000'000, ',')), Contains("8000000 values"));
}

constexpr char kBabel[] = R"({
  "1234": {
    "babel_sid": 1234, "dur": 4.5, "feat_p": "KIT/KIT/3/kick_high02_poses.npz",
    "seq_ann": {"labels": [{"raw_label": "kicks", "proc_label": "kick", "act_cat": ["kick"]}]},
    "frame_ann": {"labels": [
      {"proc_label": "kick", "act_cat": ["kick", "leg movements"], "start_t": 1, "end_t": 2.5},
      {"proc_label": "stand", "act_cat": ["stand"], "start_t": 0, "end_t": 1},
      {"proc_label": "wave", "act_cat": null, "start_t": 2, "end_t": 4},
      {"proc_label": "none", "act_cat": [], "start_t": 3, "end_t": 3}]}},
  "77": {
    "feat_p": "CMU/01/01_01_poses.npz", "frame_ann": null,
    "seq_ann": {"labels": [{"raw_label": "he walks", "proc_label": "walk", "act_cat": null}]}},
  "78": {"feat_p": "CMU/01/01_02_poses.npz",
    "frame_anns": [{"labels": [{"raw_label": "hop", "start_t": 0, "end_t": 1}]}, {"labels": []}]}
})";

TEST_CASE("BABEL: categories or texts; labels that overlap are on further tracks",
          "[client][annotation]") {
  const auto file = ReadAnnotations(AnnotationFormat::kBabel, "train.json", kBabel, "babel");
  REQUIRE(file.ok());
  std::vector<std::string> lines;
  for (const Annotation& each : file->annotations) {
    lines.push_back(
        each.clip + " " + each.track + " " + each.label + " " +
        std::to_string(static_cast<int>(10 * each.start_seconds)) + "-" +
        (each.end_seconds ? std::to_string(static_cast<int>(10 * *each.end_seconds)) : "end"));
  }
  CHECK(lines == std::vector<std::string>{
                     "kick_high02_poses babel stand 0-10", "kick_high02_poses babel kick 10-25",
                     "kick_high02_poses babel-2 leg movements 10-25",
                     "kick_high02_poses babel-3 wave 20-40", "01_01_poses babel walk 0-end",
                     "01_02_poses babel hop 0-10"});
  CHECK(file->annotations[0].place == "train.json: 1234.frame_ann.labels[1]");
  REQUIRE(file->notes.size() == 2);
  CHECK_THAT(file->notes[0], Contains("end before they begin, not imported: 1"));
  CHECK_THAT(file->notes[1], Contains("further annotators, not imported: 1"));
}

TEST_CASE("BABEL: errors name sequence and label", "[client][annotation]") {
  const auto error = [](const std::string& text) {
    return ErrorOf(AnnotationFormat::kBabel, text);
  };
  CHECK(error("[]") == "a.x: expected an object of sequences, found array");
  CHECK(error(R"({"1": {}})") == "a.x: 1: feat_p: expected a file name, found nothing");
  CHECK(error(R"({"1": {"feat_p": "a.npz", "frame_ann": {"labels": [{"proc_label": "x"}]}}})") ==
        "a.x: 1.frame_ann.labels[0]: expected start_t and end_t");
  CHECK(error(R"({"1": {"feat_p": "a.npz", "seq_ann": {"labels": [{"act_cat": [1]}]}}})") ==
        "a.x: 1.seq_ann.labels[0]: act_cat: expected texts, found number");
  std::string many = R"({"1": {"feat_p": "a.npz", "frame_ann": {"labels": [)";
  for (int i = 0; i < 65; ++i) {
    many += std::string(i > 0 ? "," : "") + R"({"proc_label": "x", "start_t": 0, "end_t": 1})";
  }
  CHECK_THAT(error(many + "]}}}"), Contains("at most 64 labels at the same time"));
}

}  // namespace
}  // namespace motiondb::tests::annotation_formats_test
