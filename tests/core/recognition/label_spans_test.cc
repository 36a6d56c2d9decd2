// Recognition of parts of clips with labelled spans.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "core/graph/transition_graph.h"
#include "core/inference/lattice.h"
#include "core/model/label_units.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/recognize.h"
#include "tests/support/some_clips.h"
#include "tests/support/synthetic_states.h"
#include "tests/support/takes.h"

namespace motiondb::tests::label_spans_test {
namespace {

constexpr int kFrames = 60;

core::Model ModelOfInputs(std::vector<core::BuildInput> inputs) {
  core::BuildSettings settings;
  settings.min_frames = 6;
  auto model =
      core::BuildModel(settings, SmallMarkerSet(3), std::move(inputs), core::RunSerially, {});
  INFO(model.status());
  REQUIRE(model.ok());
  core::RecognitionCalibration calibration;
  calibration.window.weight = {0.02, 1};
  calibration.window.familiarity = {-4, -2, 0, 2, 4};
  model->set_recognition(calibration);
  return *std::move(model);
}

// Four takes of the clips a, b and a without label, and a whole clip b. Hands hold a cup in the
// second half of the first take.
core::Model ModelOfTakes() {
  std::vector<core::BuildInput> clips = WanderingClips(16, kFrames, SmallMarkerSet(3), 31);
  std::vector<core::BuildInput> takes;
  for (int t = 0; t < 4; ++t) {
    std::vector<core::BuildInput> parts = {clips[4 * t], clips[4 * t + 1], clips[4 * t + 2]};
    parts[2].labels = "";
    takes.push_back(JoinClips(parts, "take" + std::to_string(t)));
  }
  takes[0].labels.Set("hands", {{"cup", 90, 90}});
  takes.push_back(clips[15]);
  return ModelOfInputs(std::move(takes));
}

core::StateSequence Window(int clip, int first) {
  core::StateSequence states = WanderingClips(16, kFrames, SmallMarkerSet(3), 31)[clip].states;
  states.states = states.states.middleRows(first, 24).eval();
  states.root_path = states.root_path.middleRows(first, 24).eval();
  return states;
}

double Sum(const core::RecognizedWindow& window) {
  double sum = window.unknown_probability.value_or(0);
  for (const core::LabelScore& label : window.labels) sum += label.probability;
  return sum;
}

}  // namespace

TEST_CASE("Recognize: a span over the whole clip gives the same bits as a clip's label",
          "[core][recognition]") {
  std::vector<core::BuildInput> inputs = WanderingClips(6, kFrames, SmallMarkerSet(3), 31);
  const core::Model by_label = ModelOfInputs(inputs);
  for (core::BuildInput& input : inputs) {
    const std::string label = input.label();
    input.labels = {};
    input.labels.Set(core::kActionTrack, {{label, 0, kFrames}});
  }
  const core::Model by_span = ModelOfInputs(inputs);
  CHECK(by_label.metric().whitening == by_span.metric().whitening);
  for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
    core::RecognizeOptions options;
    options.method = method;
    const auto a = core::Recognize(by_label, Window(3, 10), options);
    const auto b = core::Recognize(by_span, Window(3, 10), options);
    REQUIRE((a.ok() && b.ok()));
    CHECK(a->front().familiarity == b->front().familiarity);
    for (std::size_t l = 0; l < 2; ++l) {
      CHECK(a->front().labels[l].label == b->front().labels[l].label);
      CHECK(a->front().labels[l].probability == b->front().labels[l].probability);
    }
    for (std::size_t c = 0; c < 6; ++c) {
      CHECK(a->front().clips[c].log_probability == b->front().clips[c].log_probability);
      CHECK(a->front().clips[c].label == by_label.clips()[a->front().clips[c].clip].label());
    }
  }
}

TEST_CASE("Recognize: labels have the evidence of their best span, clips that of their best part",
          "[core][recognition]") {
  const core::Model model = ModelOfTakes();
  const core::LabelUnits& units = *model.action_units();
  REQUIRE(units.all().size() == 13);
  for (const int clip : {0, 1, 2, 15}) {
    const core::StateSequence observation = Window(clip, 13);
    core::FrameMatrix scaled = observation.states;
    model.scale().Apply(scaled);
    const core::FrameMatrix observed =
        core::Project(model.metric(), scaled)(core::ComparedFrames(0, 24, 2, false), Eigen::all);
    std::map<std::string, double> of_label;
    std::map<int, std::pair<double, std::string>> of_clip;
    for (const core::LabelUnit& unit : units.all()) {
      const double evidence =
          core::AlignToClip(model.metric_frames(), unit.rows, observed, false).log_evidence;
      const std::string& name = units.NameOf(unit.label);
      if (unit.label >= 0) {
        const auto [known, is_new] = of_label.try_emplace(name, evidence);
        known->second = std::max(known->second, evidence);
      }
      const auto [known, is_new] = of_clip.try_emplace(unit.clip, std::pair(evidence, name));
      if (evidence > known->second.first) known->second = {evidence, name};
    }
    const auto windows = core::Recognize(model, observation, {});
    REQUIRE((windows.ok() && windows->size() == 1));
    const core::RecognizedWindow& window = windows->front();
    REQUIRE(window.labels.size() == 2);
    const double weight = model.recognition().window.weight.At(12);
    const double log_odds = weight * (of_label["a"] - of_label["b"]);
    for (const core::LabelScore& label : window.labels) {
      CHECK(label.probability ==
            Approx(1 / (1 + std::exp(label.label == "a" ? -log_odds : log_odds))).epsilon(1e-3));
    }
    REQUIRE(window.clips.size() == of_clip.size());
    for (const core::ClipScore& score : window.clips) {
      CHECK(score.log_probability == Approx(of_clip[score.clip].first).epsilon(1e-5));
      CHECK(score.label == of_clip[score.clip].second);
    }
    CHECK(Sum(window) == Approx(1));
  }
}

TEST_CASE("Recognize: kPaper uses the graph of each span", "[core][recognition]") {
  const core::Model model = ModelOfTakes();
  const core::LabelUnits& units = *model.action_units();
  const core::StateSequence observation = Window(1, 20);
  core::FrameMatrix scaled = observation.states;
  model.scale().Apply(scaled);
  for (const int layer : {4, model.layer_count()}) {
    core::RecognizeOptions options;
    options.method = core::Method::kPaper;
    options.layer = layer;
    const auto windows = core::Recognize(model, observation, options);
    REQUIRE(windows.ok());
    core::EmissionMatrix density(24, model.tree().node_count(layer));
    double evidence = 0;
    for (Eigen::Index t = 0; t < 24; ++t) {
      for (Eigen::Index n = 0; n < density.cols(); ++n) {
        density(t, n) = model.gaussians().LogDensity(
            model.tree().branch(layer, static_cast<int>(n)), scaled.row(t).data());
      }
      evidence += core::LogSum(density.row(t));
    }
    std::map<std::string, std::vector<double>> of_label;
    for (const core::LabelUnit& unit : units.all()) {
      std::vector<std::int32_t> nodes;
      for (int f = 0; f < unit.frame_count; ++f) {
        nodes.push_back(model.tree().node_of_frame(layer, unit.first_frame + f));
      }
      const core::ClipGraph graph = core::CountClipTransitions(nodes);
      core::EmissionMatrix emission(24, std::ssize(graph.nodes));
      for (Eigen::Index s = 0; s < emission.cols(); ++s) {
        emission.col(s) = density.col(graph.nodes[s]);
      }
      if (unit.label < 0) continue;
      of_label[units.NameOf(unit.label)].push_back(
          core::LogGeneration(graph.transitions, emission, 1e-6) - evidence);
    }
    std::map<std::string, double> mean;
    for (const auto& [label, logs] : of_label) {
      mean[label] = core::LogSum(logs) - std::log(static_cast<double>(logs.size()));
    }
    const double odds = std::exp(mean["a"] - mean["b"]);
    for (const core::LabelScore& label : windows->front().labels) {
      CHECK(label.probability ==
            Approx(label.label == "a" ? odds / (1 + odds) : 1 / (1 + odds)).margin(1e-9));
    }
  }
}

TEST_CASE("Recognize: other tracks have the share of matching frames with each label",
          "[core][recognition]") {
  const core::Model model = ModelOfTakes();
  for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
    core::RecognizeOptions options;
    options.method = method;
    for (const int clip : {0, 2, 9}) {
      const auto windows = core::Recognize(model, Window(clip, 13), options);
      REQUIRE(windows.ok());
      const auto& others = windows->front().other_tracks;
      REQUIRE(others.size() == 1);
      CHECK(others[0].track == "hands");
      double sum = others[0].none;
      for (const core::LabelScore& label : others[0].labels) {
        CHECK(label.label == "cup");
        sum += label.probability;
      }
      CHECK(sum == Approx(1));
    }
    // On the other track, its label is the only one; action is a marginal.
    options.track = "hands";
    const auto windows = core::Recognize(model, Window(2, 13), options);
    REQUIRE(windows.ok());
    const core::RecognizedWindow& window = windows->front();
    REQUIRE(window.labels.size() == 1);
    CHECK(window.labels[0].label == "cup");
    CHECK(Sum(window) == Approx(1));
    REQUIRE(window.other_tracks.size() == 1);
    CHECK(window.other_tracks[0].track == core::kActionTrack);
  }
  // A motion that only matches the part with the cup.
  core::RecognitionCalibration sharp = model.recognition();
  sharp.window.weight = {5, 1};
  core::Model certain = model;
  certain.set_recognition(sharp);
  const auto held = core::Recognize(certain, Window(2, 13), {});
  REQUIRE(held.ok());
  REQUIRE(held->front().other_tracks[0].labels.size() == 1);
  CHECK(held->front().other_tracks[0].labels[0].probability == Approx(1).margin(1e-6));
}

TEST_CASE("Recognize: clips without labels count, but give no label evidence",
          "[core][recognition]") {
  std::vector<core::BuildInput> inputs = WanderingClips(5, kFrames, SmallMarkerSet(3), 31);
  inputs[4].labels = "";
  const core::Model model = ModelOfInputs(inputs);
  for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
    core::RecognizeOptions options;
    options.method = method;
    const auto windows = core::Recognize(model, Window(4, 13), options);
    REQUIRE(windows.ok());
    const auto unlabelled = std::ranges::find(windows->front().clips, 4, &core::ClipScore::clip);
    REQUIRE(unlabelled != windows->front().clips.end());
    CHECK(unlabelled->label.empty());
    if (method == core::Method::kBest) CHECK(unlabelled == windows->front().clips.begin());
    CHECK(windows->front().labels.size() == 2);
    options.mask = MaskOf(model, {false, false, false, false, true});
    const auto alone = core::Recognize(model, Window(4, 13), options);
    REQUIRE(alone.ok());
    CHECK(alone->front().labels.empty());
    CHECK_FALSE(alone->front().unknown_probability.has_value());
  }
}

TEST_CASE("WithLabels: names the new labels and shares the stored states", "[core][model]") {
  const core::Model model = ModelOfTakes();
  std::vector<core::ClipLabels> labels(model.clips().size());
  labels[0].labels.Set(core::kActionTrack, {{"sit", 10, 20}, {"stand", 30, 100}});
  labels[1] = {"walk", "someone"};
  const auto relabelled = model.WithLabels(labels);
  REQUIRE(relabelled.ok());
  CHECK(relabelled->action_units()->labels() == std::vector<std::string>{"sit", "stand", "walk"});
  CHECK(relabelled->clips()[1].label() == "walk");
  CHECK(relabelled->clips()[1].subject == "someone");
  CHECK(relabelled->states().data() == model.states().data());
  CHECK(model.action_units()->labels() == std::vector<std::string>{"a", "b"});
  const auto windows = core::Recognize(*relabelled, Window(1, 13), {});
  REQUIRE(windows.ok());
  CHECK(windows->front().labels.size() == 3);

  labels[2].labels.Set("hands", {{"cup", 0, 10'000}});
  const auto refused = model.WithLabels(labels);
  CHECK(refused.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK(std::string(refused.status().message()).find("take2") != std::string::npos);
  labels.pop_back();
  CHECK_FALSE(model.WithLabels(labels).ok());
}

}  // namespace motiondb::tests::label_spans_test
