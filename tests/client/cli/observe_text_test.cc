#include <catch2/catch.hpp>

#include "client/cli/observe_replay.h"

namespace motiondb::tests::observe_text_test {

using namespace client;  // NOLINT: the functions under test

TEST_CASE("ObserveAnswerLine: labels, state, prediction and a new model", "[client][cli]") {
  v1::ObserveResponse answer;
  CHECK(ObserveAnswerLine(answer, 0.1, 0.5) == "   0.10 s  no frame with both hips yet");
  answer.mutable_state()->set_node_id(37);
  answer.mutable_state()->set_probability(0.875);
  answer.set_familiarity(0.5);
  for (const auto& [label, probability] : {std::pair("walk", 0.9), {"jog", 0.09}, {"kick", 0.01}}) {
    v1::LabelProbability& to = *answer.add_labels();
    to.set_label(label);
    to.set_probability(probability);
  }
  const std::string line = ObserveAnswerLine(answer, 12.5, 0.5);
  CHECK_THAT(line, Catch::StartsWith("  12.50 s  walk 0.90, jog 0.09"));
  CHECK_THAT(line, Catch::Contains("familiarity 0.50") && Catch::Contains("node   37 0.88") &&
                       !Catch::Contains("kick") && !Catch::Contains("ahead") &&
                       !Catch::Contains("model"));
  v1::TrackLabels& carries = *answer.add_other_tracks();
  carries.set_track("carries");
  carries.add_labels()->set_label("box");
  carries.mutable_labels(0)->set_probability(0.75);
  CHECK_THAT(ObserveAnswerLine(answer, 12.5, 0.5), Catch::EndsWith("  carries: box 0.75"));
  carries.mutable_labels(0)->set_probability(0.25);
  CHECK_THAT(ObserveAnswerLine(answer, 12.5, 0.5), Catch::EndsWith("  carries: none 0.75"));
  answer.clear_other_tracks();
  v1::PredictedFrame& ahead = *answer.add_horizons();
  ahead.set_seconds(0.4);
  ahead.set_expected_error_m(0.036);
  answer.set_model_replaced(true);
  answer.set_model_version(2);
  CHECK_THAT(ObserveAnswerLine(answer, 1, 0.5),
             Catch::Contains("0.40 s ahead +-3.6 cm") && Catch::EndsWith("(now model 2)"));
  answer.set_calibration(v1::CALIBRATION_OWN);
  CHECK_THAT(ObserveAnswerLine(answer, 1, 0.5), Catch::EndsWith("(now model 2)"));
  answer.set_calibration(v1::CALIBRATION_PREVIOUS);
  CHECK_THAT(ObserveAnswerLine(answer, 1, 0.5),
             Catch::EndsWith("(now a newer model, not calibrated yet)"));
}

TEST_CASE("ReconnectText: the lost frames", "[client][cli]") {
  ObserveReconnect reconnect{absl::UnavailableError("the server is gone"),
                             std::chrono::milliseconds(320), 0, 0};
  CHECK(ReconnectText(reconnect, 60) ==
        "the server is gone; continued after 0.32 s; no frame is lost");
  reconnect.lost_frames = 90;
  reconnect.first_frame = 90;
  CHECK(ReconnectText(reconnect, 60) ==
        "the server is gone; continued after 0.32 s; further answers do not depend on the 90 "
        "frames before 1.50 s");
}

TEST_CASE("ReplayText: rate, and latencies if messages were sent at a fixed rate",
          "[client][cli]") {
  v1::ObserveResponse last;
  last.set_model_version(3);
  ReplayStatistics figures{.frames = 200, .seconds = 2, .latencies_ms = {}};
  for (int i = 100; i > 0; --i) figures.latencies_ms.push_back(i);
  CHECK(ReplayText(figures, last, false) == "200 frames in 2.00 s, 100 per second; model 3\n");
  CHECK_THAT(
      ReplayText(figures, last, true),
      Catch::EndsWith("100 answers after 50.00 ms (median), 99.00 (99 %), 100.00 (longest)\n"));
  last.set_late_frames(1);
  last.set_missing_frames(2);
  CHECK_THAT(ReplayText(figures, last, false), Catch::EndsWith("1 frame late, 2 missing\n"));
}

}  // namespace motiondb::tests::observe_text_test
