// Recognition in some clips, compared with exhaustive computations over these clips alone.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "core/graph/transition_graph.h"
#include "core/inference/lattice.h"
#include "core/model/clip_graphs.h"
#include "core/model/label_units.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/recognize.h"
#include "core/recognition/shortlist.h"
#include "core/recognition/window_alignment.h"
#include "tests/support/some_clips.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::masked_recognition_test {
namespace {

constexpr int kFrames = 120;

// Clips with the labels "a" to "d".
core::Model FourLabels(int clips) {
  const core::MarkerSet set = SmallMarkerSet(3);
  auto inputs = WanderingClips(clips, kFrames, set, 31);
  const auto others = WanderingClips(clips, kFrames, set, 57);
  for (int c = 0; c < clips; ++c) {
    if (c % 4 >= 2) inputs[c].states = others[c].states;
    inputs[c].labels = std::string(1, static_cast<char>('a' + c % 4));
  }
  core::BuildSettings settings;
  settings.min_frames = 6;
  auto model = core::BuildModel(settings, set, std::move(inputs), core::RunSerially, {});
  REQUIRE(model.ok());
  core::RecognitionCalibration calibration;
  calibration.window.weight = {0.02, 1};
  calibration.whole.weight = {0.1, 0.5};
  for (int i = 0; i < 200; ++i) {
    calibration.window.familiarity.push_back(-6.0F + 0.05F * static_cast<float>(i));
  }
  calibration.whole.familiarity = calibration.window.familiarity;
  model->set_recognition(calibration);
  return *std::move(model);
}

core::StateSequence Observation(const core::Model& model, unsigned seed, int first, int count) {
  core::StateSequence clip = WanderingClips(4, kFrames, model.marker_set(), seed)[seed % 4].states;
  clip.states = clip.states.middleRows(first, count).eval();
  clip.root_path = clip.root_path.middleRows(first, count).eval();
  return clip;
}

core::FrameMatrix Scaled(const core::Model& model, const core::StateSequence& observation) {
  core::FrameMatrix scaled = observation.states;
  model.scale().Apply(scaled);
  return scaled;
}

std::map<std::string, double> Softmax(std::map<std::string, double> logs) {
  double sum = 0;
  double peak = -std::numeric_limits<double>::infinity();
  for (const auto& [label, log] : logs) peak = std::max(peak, log);
  for (auto& [label, log] : logs) sum += log = std::exp(log - peak);
  for (auto& [label, p] : logs) p /= sum;
  return logs;
}

void CheckLabels(const core::RecognizedWindow& window,
                 const std::map<std::string, double>& expected) {
  REQUIRE(window.labels.size() == expected.size());
  for (const core::LabelScore& label : window.labels) {
    REQUIRE(expected.contains(label.label));
    CHECK(label.probability == Approx(expected.at(label.label)).epsilon(1e-4).margin(1e-9));
  }
}

// Aligns every allowed clip, without a shortlist.
void CheckBest(const core::Model& model, const core::ClipMask& mask,
               const core::StateSequence& observation, bool whole,
               const core::RecognizedWindow& window) {
  const core::FrameMatrix scaled = Scaled(model, observation);
  const int width = observation.frame_count();
  const std::vector<int> compared = core::ComparedFrames(0, width, 2, whole);
  const core::FrameMatrix observed = core::Project(model.metric(), scaled)(compared, Eigen::all);
  std::map<int, double> of_clip;
  std::map<std::string, double> of_label;
  std::vector<core::NearestFrame> nearest(compared.size(),
                                          {std::numeric_limits<float>::infinity(), 0});
  for (const int clip : mask.clips()) {
    const auto aligned = core::AlignToClip(
        model.metric_frames(), model.metric_frames().rows.of_clip(clip), observed, whole);
    of_clip[clip] = aligned.log_evidence;
    const auto [known, is_new] =
        of_label.try_emplace(model.clips()[clip].label(), aligned.log_evidence);
    if (!is_new) known->second = std::max(known->second, aligned.log_evidence);
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      if (aligned.nearest[i].squared_distance < nearest[i].squared_distance) {
        nearest[i] = aligned.nearest[i];
      }
    }
  }
  REQUIRE(window.clips.size() == of_clip.size());
  for (const core::ClipScore& score : window.clips) {
    REQUIRE(of_clip.contains(score.clip));
    CHECK(score.log_probability == Approx(of_clip[score.clip]).epsilon(1e-5));
  }
  const core::AnswerCalibration& calibration = model.recognition().Of(whole);
  for (auto& [label, log] : of_label) log *= calibration.weight.At(std::ssize(compared));
  CheckLabels(window, Softmax(of_label));
  double squares = 0;
  for (std::size_t i = 0; i < compared.size(); ++i) {
    const auto state = scaled.row(compared[i]);
    squares +=
        ((state - core::NearestState(model, nearest[i].frame, state)) * model.metric().whitening)
            .squaredNorm();
  }
  const double score = core::FamiliarityOfDifference(
      squares / static_cast<double>(std::ssize(compared) * scaled.cols()));
  CHECK(window.familiarity == Approx(calibration.FamiliarityRank(score)).margin(0.006));
}

// Computes generation probabilities over the allowed clips and the nodes that they visit.
void CheckPaper(const core::Model& model, const core::ClipMask& mask,
                const core::StateSequence& observation, const core::RecognizedWindow& window) {
  const core::FrameMatrix scaled = Scaled(model, observation);
  const int layer = window.layer;
  std::vector<core::ModelClip> clips;
  std::set<int> visited;
  for (const int c : mask.clips()) {
    clips.push_back(model.clips()[c]);
    for (int f = 0; f < clips.back().frame_count; ++f) {
      visited.insert(model.tree().node_of_frame(layer, clips.back().first_frame + f));
    }
  }
  const std::vector<int> nodes(visited.begin(), visited.end());
  core::EmissionMatrix density(scaled.rows(), std::ssize(nodes));
  double evidence = 0;
  for (Eigen::Index t = 0; t < density.rows(); ++t) {
    for (Eigen::Index i = 0; i < density.cols(); ++i) {
      density(t, i) =
          model.gaussians().LogDensity(model.tree().branch(layer, nodes[i]), scaled.row(t).data());
    }
    evidence += core::LogSum(density.row(t));
  }
  const auto place = [&](int node) {
    return static_cast<std::int32_t>(std::ranges::lower_bound(nodes, node) - nodes.begin());
  };
  std::map<std::string, std::vector<double>> of_label;
  std::map<int, double> of_clip;
  for (const int c : mask.clips()) {
    const auto graph = model.clip_graph(layer, c);
    core::EmissionMatrix emission(density.rows(), std::ssize(graph->nodes));
    for (Eigen::Index s = 0; s < emission.cols(); ++s) {
      emission.col(s) = density.col(place(graph->nodes[s]));
    }
    of_clip[c] = core::LogGeneration(graph->transitions, emission, 1e-6) - evidence;
    of_label[model.clips()[c].label()].push_back(of_clip[c]);
  }
  REQUIRE(window.clips.size() == of_clip.size());
  for (const core::ClipScore& score : window.clips) {
    CHECK(score.log_probability == Approx(of_clip.at(score.clip)).epsilon(1e-9));
  }
  std::map<std::string, double> logs;
  for (const auto& [label, all] : of_label) {
    logs[label] = core::LogSum(all) - std::log(static_cast<double>(all.size()));
  }
  CheckLabels(window, Softmax(logs));

  // The global graph of the allowed clips, with only their nodes.
  std::vector<std::vector<std::int32_t>> sequences;
  for (const core::ModelClip& clip : clips) {
    std::vector<std::int32_t>& sequence = sequences.emplace_back();
    for (int f = 0; f < clip.frame_count; ++f) {
      sequence.push_back(place(model.tree().node_of_frame(layer, clip.first_frame + f)));
    }
  }
  const auto graph = core::CountTransitions(sequences, static_cast<int>(nodes.size()));
  CHECK(window.familiarity ==
        Approx(model.familiarity().Rank(layer, core::FamiliarityScore(graph, density)))
            .margin(0.005));
}

}  // namespace

TEST_CASE("Recognize: with a mask equals an exhaustive search of the allowed clips",
          "[core][recognition]") {
  const core::Model model = FourLabels(16);
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const auto mask = SomeClips(model, 1 + static_cast<int>(seed) % 6, seed);
    const core::StateSequence observation = Observation(model, 31 + seed, 20, 24);
    core::RecognizeOptions options;
    options.mask = mask;
    CAPTURE(seed);
    for (const bool whole : {false, true}) {
      options.method = core::Method::kBest;
      options.whole = whole;
      const auto best = core::Recognize(model, observation, options);
      REQUIRE((best.ok() && best->size() == 1));
      CheckBest(model, *mask, observation, whole, best->front());
    }
    options.method = core::Method::kPaper;
    for (const int layer : {0, 3}) {
      options.layer = layer;
      const auto paper = core::Recognize(model, observation, options);
      REQUIRE((paper.ok() && paper->size() == 1));
      CheckPaper(model, *mask, observation, paper->front());
    }
  }
}

TEST_CASE("Recognize: a mask of all clips changes nothing", "[core][recognition]") {
  const core::Model model = FourLabels(70);
  const core::StateSequence observation = Observation(model, 33, 0, 100);
  for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
    core::RecognizeOptions options;
    options.method = method;
    const auto all = core::Recognize(model, observation, options);
    options.mask = SomeClips(model, 70, 1);
    const auto masked = core::Recognize(model, observation, options);
    REQUIRE((all.ok() && masked.ok() && all->size() == masked->size()));
    for (std::size_t w = 0; w < all->size(); ++w) {
      CHECK((*all)[w].familiarity == (*masked)[w].familiarity);
      for (std::size_t c = 0; c < (*all)[w].clips.size(); ++c) {
        CHECK((*all)[w].clips[c].clip == (*masked)[w].clips[c].clip);
        CHECK((*all)[w].clips[c].log_probability == (*masked)[w].clips[c].log_probability);
      }
      for (std::size_t l = 0; l < (*all)[w].labels.size(); ++l) {
        CHECK((*all)[w].labels[l].probability == (*masked)[w].labels[l].probability);
      }
    }
  }
}

TEST_CASE("ShortlistClips: with a mask ranks the allowed clips by the nodes with their frames",
          "[core][recognition]") {
  const core::Model model = FourLabels(150);
  const int layer = model.layer_count();
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const auto mask = SomeClips(model, 80, seed);
    const core::FrameMatrix observed =
        core::Project(model.metric(), Scaled(model, Observation(model, 31 + seed, 10, 20)));
    std::vector<double> nearer(150);
    for (Eigen::Index t = 0; t < observed.rows(); ++t) {
      std::vector<std::pair<double, int>> nodes;
      for (int node = 0; node < model.tree().node_count(layer); ++node) {
        if (!core::IsAllowedNode(model, layer, node, mask.get())) continue;
        nodes.emplace_back((observed.row(t) - model.clip_index().means().row(node)).squaredNorm(),
                           node);
      }
      std::ranges::sort(nodes);
      nodes.resize(std::min<std::size_t>(64, nodes.size()));
      std::vector<bool> found(150);
      for (const auto& [distance, node] : nodes) {
        for (const int clip : model.clip_index().clips(node)) {
          if (mask->allows(clip) && !found[clip]) nearer[clip] += nodes.back().first - distance;
          found[clip] = true;
        }
      }
    }
    const auto shortlist = core::ShortlistClips(model, nullptr, observed, mask.get());
    REQUIRE(shortlist.size() == 64);
    const std::set<int> listed(shortlist.begin(), shortlist.end());
    CHECK(listed.size() == 64);
    double poorest = std::numeric_limits<double>::infinity();
    for (const int clip : shortlist) {
      CHECK(mask->allows(clip));
      poorest = std::min(poorest, nearer[clip]);
    }
    for (const int clip : mask->clips()) {
      if (!listed.contains(clip)) CHECK(nearer[clip] <= poorest * (1 + 1e-4) + 1e-3);
    }
  }
}

}  // namespace motiondb::tests::masked_recognition_test
