// Streams on models with several tracks of labels.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/observe/observer.h"
#include "tests/core/observe/observing.h"

namespace motiondb::tests::observed_tracks_test {
namespace {

core::Model ModelWithTracks() {
  const core::Model model = PointModel(3, 3);
  std::vector<core::ClipLabels> labels;
  for (std::size_t c = 0; c < model.clips().size(); ++c) {
    core::LabelTracks tracks;
    const std::string label = model.clips()[c].label();
    tracks.Set(core::kActionTrack, {{label, 0, 60}, {label + "2", 75, 75}});
    if (c % 2 == 0) tracks.Set("hands", {{"cup", 30, 50}, {"box", 80, 40}});
    labels.push_back({tracks, ""});
  }
  auto relabelled = model.WithLabels(labels);
  REQUIRE(relabelled.ok());
  return *std::move(relabelled);
}

}  // namespace

TEST_CASE("Observer: equals Recognize on every track of labels", "[core][observe]") {
  const core::Model model = ModelWithTracks();
  const core::MarkerMotion motion = Stream(90);
  for (const char* const track : {"", "hands"}) {
    core::ObserverOptions options;
    options.track = track;
    const auto observer = Observe(model, options);
    for (int t = 0; t < 90; ++t) {
      Append(*observer, t, motion.positions_m.row(t));
      if (t % 3 != 2) continue;
      const core::Observed answer = Answer(*observer);
      core::MarkerMotion prefix = motion;
      prefix.positions_m.conservativeResize(t + 1, Eigen::NoChange);
      core::RecognizeOptions recognize;
      recognize.track = track;
      const auto windows =
          core::Recognize(model, core::PastAt(PointStates(prefix), t, 24), recognize);
      REQUIRE(windows.ok());
      const core::RecognizedWindow& window = windows->back();
      CAPTURE(t, track);
      CheckLabels(answer.labels, window.labels);
      CHECK(answer.familiarity == Approx(window.familiarity).margin(0.003));
      REQUIRE(answer.other_tracks.size() == 1);
      REQUIRE(window.other_tracks.size() == 1);
      CHECK(answer.other_tracks[0].track == window.other_tracks[0].track);
      CHECK(answer.other_tracks[0].none == Approx(window.other_tracks[0].none).margin(1e-3));
      CheckLabels(answer.other_tracks[0].labels, window.other_tracks[0].labels);
    }
  }
}

}  // namespace motiondb::tests::observed_tracks_test
