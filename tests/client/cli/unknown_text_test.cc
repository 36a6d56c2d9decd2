#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/observe.pb.h>
#include <motiondb/v1/query.pb.h>

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/database_text.h"
#include "client/cli/observe_replay.h"
#include "client/cli/query/recognition_text.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::unknown_text_test {
namespace {

using namespace client;  // NOLINT: the functions under test

constexpr double kThreshold = 0.5;

template <typename Window>
void SetLabels(const std::vector<std::pair<const char*, double>>& labels, Window& window) {
  for (const auto& [label, probability] : labels) {
    v1::LabelProbability& to = *window.add_labels();
    to.set_label(label);
    to.set_probability(probability);
  }
}

// Two windows: unknown with the probability 0.83, and a walk.
v1::RecognizeResponse UnknownThenWalk() {
  v1::RecognizeResponse response;
  auto& unknown = *response.add_windows();
  unknown.set_end_seconds(0.4);
  SetLabels({{"walk", 0.1}, {"jog", 0.07}}, unknown);
  unknown.set_unknown_probability(0.83);
  unknown.set_familiarity(0.02);
  auto& walk = *response.add_windows();
  walk.set_start_seconds(0.1);
  walk.set_end_seconds(0.5);
  SetLabels({{"walk", 0.95}, {"jog", 0.046}}, walk);
  walk.set_unknown_probability(0.004);
  walk.set_familiarity(0.71);
  return response;
}

std::string TextOf(const v1::RecognizeResponse& response, double threshold) {
  return WithStyles(RecognitionText(response, threshold, Windows::kMerged), false);
}

TEST_CASE("RecognitionText: unknown windows are called so and counted", "[client][cli]") {
  const v1::RecognizeResponse response = UnknownThenWalk();
  CHECK(TextOf(response, kThreshold) ==
        "FROM (s)  TO (s)  WINDOWS  ANSWER   PROBABILITY  UNKNOWN  FAMILIARITY  BEST CLIP\n"
        "    0.00    0.40        1  unknown         0.83     0.83         0.02  none\n"
        "    0.10    0.50        1  walk            0.95     0.00         0.71  none\n"
        "unknown 50 % (1 of 2 windows), walk 50 % (1 of 2 windows)\n");
  CHECK(TextOf(response, 0.9) ==
        "FROM (s)  TO (s)  WINDOWS  ANSWER  PROBABILITY  UNKNOWN  FAMILIARITY  BEST CLIP\n"
        "    0.00    0.50        2  walk           0.53     0.42         0.36  none\n"
        "walk 100 % (2 of 2 windows)\n");
  CHECK_THAT(TextOf(response, 0.83),
             Catch::EndsWith("\nwalk 100 % (2 of 2 windows)\n"));  // not greater
  CHECK_THAT(TextOf(response, 0), Catch::EndsWith("\nunknown 100 % (2 of 2 windows)\n"));
}

TEST_CASE("RecognitionText: unknown windows are kept apart from a label named unknown",
          "[client][cli]") {
  v1::RecognizeResponse response = UnknownThenWalk();
  response.mutable_windows(1)->mutable_labels(0)->set_label("unknown");
  CHECK_THAT(TextOf(response, kThreshold),
             Catch::EndsWith("\nunknown 50 % (1 of 2 windows), unknown 50 % (1 of 2 windows)\n"));
}

TEST_CASE("RecognitionText: windows without the probability stay as they are", "[client][cli]") {
  v1::RecognizeResponse response = UnknownThenWalk();
  response.mutable_windows(0)->clear_unknown_probability();
  CHECK_THAT(TextOf(response, kThreshold),
             Catch::Contains("    0.00    0.50        2  walk           0.53     0.00  ") &&
                 Catch::EndsWith("\nwalk 100 % (2 of 2 windows)\n"));
  response.mutable_windows(1)->clear_unknown_probability();
  CHECK_THAT(TextOf(response, 0), Catch::Contains("  walk           0.53         0.36  none") &&
                                      !Catch::Contains("UNKNOWN") && !Catch::Contains("unknown"));
}

TEST_CASE("ObserveAnswerLine: unknown precedes the labels, or follows them", "[client][cli]") {
  v1::ObserveResponse answer;
  answer.mutable_state()->set_node_id(37);
  answer.mutable_state()->set_probability(0.875);
  SetLabels({{"walk", 0.1}, {"jog", 0.07}, {"kick", 0}}, answer);
  answer.set_unknown_probability(0.83);
  const std::string line = ObserveAnswerLine(answer, 12.5, kThreshold);
  CHECK(line == "  12.50 s  unknown 0.83, walk 0.10, jog 0.07  familiarity 0.00  node   37 0.88");
  CHECK(line.size() < 80);
  CHECK(ObserveAnswerLine(answer, 12.5, 0.9) ==
        "  12.50 s  walk 0.10, jog 0.07, unknown 0.83  familiarity 0.00  node   37 0.88");
}

TEST_CASE("UnknownNote, DescriptionText: why there is no probability of unknown motion",
          "[client][cli]") {
  v1::DatabaseStatistics description;
  const std::string begin = "no probability of unknown motion: ";
  for (const auto& [calibration, word, note] :
       {std::tuple(v1::CALIBRATION_ONE_CLIP, "own, one clip",
                   "the database has one clip; ingest clips of other labels and subjects"),
        {v1::CALIBRATION_ONE_LABEL, "own, one label",
         "all clips have the same label; ingest clips of other labels"},
        {v1::CALIBRATION_ONE_SUBJECT, "own, one subject",
         "the clips name fewer than two subjects; ingest clips with --subject"},
        {v1::CALIBRATION_TOO_FEW_CLIPS, "own, too few clips",
         "too few clips remain if a subject or a label is held out; ingest clips of the same "
         "labels by other subjects"},
        {v1::CALIBRATION_OLDER_VERSION, "own, older version",
         "the model was built by an older version; run `motiondb reprocess DB`"}}) {
    CHECK(UnknownNote(calibration) == begin + note + "\n");
    CHECK(CalibrationNote(calibration) == "");
    description.set_calibration(calibration);
    const std::string text = DescriptionText(description);
    CHECK_THAT(text, Catch::Contains(std::string("  ") + word + "\n") &&
                         Catch::Contains("\n" + begin + note + "\n"));
  }
  for (const auto calibration : {v1::CALIBRATION_UNSPECIFIED, v1::CALIBRATION_OWN,
                                 v1::CALIBRATION_PREVIOUS, v1::CALIBRATION_TYPICAL}) {
    CHECK(UnknownNote(calibration) == "");
  }
}

TEST_CASE("motiondb recognize: --unknown-threshold, and the note about the calibration",
          "[client][cli]") {
  FakeServer server;
  v1::RecognizeResponse answer = UnknownThenWalk();
  answer.set_calibration(v1::CALIBRATION_ONE_LABEL);
  server.Answer("Recognize", answer);
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const auto run = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"recognize", "walks", file});
    return RunMotiondb(server.address(), options);
  };
  CHECK_THAT(run({}).out, Catch::Contains("unknown 50 % (1 of 2 windows)") &&
                              Catch::EndsWith(UnknownNote(v1::CALIBRATION_ONE_LABEL)));
  CHECK_THAT(run({"--unknown-threshold", "0.9"}).out, Catch::Contains("\nwalk 100 % (2 of 2"));
  CHECK_THAT(run({"--method", "paper"}).out, !Catch::Contains("no probability"));
  const auto without_effect = run({"--method", "paper", "--unknown-threshold", "0.9"});
  CHECK(without_effect.exit_code == 2);
  CHECK_THAT(without_effect.err,
             Catch::Contains("--unknown-threshold has no effect with --method paper"));
  const std::string json = run({"--json"}).out;
  CHECK_THAT(json, Catch::Contains("\"unknown_probability\":0.83") &&
                       Catch::Contains("\"calibration\":\"CALIBRATION_ONE_LABEL\"") &&
                       !Catch::Contains("no probability"));
  CHECK(run({"--json", "--unknown-threshold", "0.9"}).out == json);
  for (const char* threshold : {"-0.1", "1.1", "nan", "high"}) {
    const auto result = run({std::string("--unknown-threshold=") + threshold});
    CHECK(result.exit_code == 2);
    CHECK_THAT(result.err, Catch::Contains("--unknown-threshold"));
  }
}

}  // namespace
}  // namespace motiondb::tests::unknown_text_test
