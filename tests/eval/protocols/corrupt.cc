#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "core/motion/error.h"
#include "core/prediction/predict.h"
#include "core/recognition/recognize.h"
#include "tests/eval/database_model.h"
#include "tests/eval/observations.h"
#include "tests/eval/protocols/protocol.h"

namespace motiondb::tests {
namespace {

constexpr float kDisplaced_m = 100;
constexpr double kAhead_s = 0.4;
constexpr double kForecastHop_s = 0.5;
constexpr core::Method kMethods[] = {core::Method::kBest, core::Method::kPaper};

struct Corruption {
  const char* name;
  // Returns the corrupt frames; applied to one clip in twenty.
  std::vector<int> (*frames)(int frame_count);
};

std::vector<int> NoFrame(int) { return {}; }
std::vector<int> OneFrame(int frame_count) { return {frame_count / 2}; }
std::vector<int> OnePercent(int frame_count) {
  std::mt19937 random(20);
  std::vector<int> frames;
  for (int i = 0; i < std::max(1, frame_count / 100); ++i) {
    frames.push_back(static_cast<int>(random() % static_cast<unsigned>(frame_count)));
  }
  return frames;
}

constexpr Corruption kCorruptions[] = {
    {"clean", NoFrame}, {"one frame", OneFrame}, {"1 % of a clip", OnePercent}};

constexpr std::pair<core::GlitchPolicy, const char*> kPolicies[] = {
    {core::GlitchPolicy::kRepair, "repair"},
    {core::GlitchPolicy::kReject, "reject"},
    {core::GlitchPolicy::kDrop, "drop"},
    {core::GlitchPolicy::kKeep, "keep"}};

// Clips of which the first of every twenty is corrupt, stored by a glitch policy.
struct Stored {
  std::vector<EvalClip> clips;  // without the rejected clips

  ClipSet set() const {
    ClipSet all;
    for (const EvalClip& clip : clips) all.push_back(&clip);
    return all;
  }
};

absl::StatusOr<Stored> Store(const Corpus& corpus, const Corruption& corruption,
                             core::GlitchPolicy policy) {
  constexpr int kEvery = 20;
  const core::MarkerScheme scheme{corpus.set, {}};
  Stored stored;
  int place = 0;
  for (const EvalClip* clip : corpus.database1_train) {
    core::MarkerMotion markers = clip->markers;
    if (place++ % kEvery == 0) {
      for (const int f : corruption.frames(static_cast<int>(markers.positions_m.rows()))) {
        markers.positions_m.row(f).array() += kDisplaced_m;
      }
    }
    auto states =
        core::Represent(scheme, markers, corpus.frame_rate_hz, policy, clip->states.leg_length_m);
    if (absl::IsInvalidArgument(states.status())) continue;
    if (!states.ok()) return states.status();
    EvalClip& kept = stored.clips.emplace_back();
    kept.name = clip->name;
    kept.label = clip->label;
    kept.source = clip->source;
    kept.states = *std::move(states);
  }
  return stored;
}

absl::StatusOr<double> WindowAccuracy(const core::Model& model, const ClipSet& test,
                                      core::Method method) {
  core::RecognizeOptions options;
  options.method = method;
  int windows = 0;
  int right = 0;
  for (const EvalClip* clip : test) {
    for (const core::StateSequence& window : SplitIntoWindows(clip->states)) {
      options.window_seconds = window.frame_count() / window.frame_rate_hz;
      MOTIONDB_ASSIGN_OR_RETURN(const auto recognized, core::Recognize(model, window, options));
      const core::RecognizedWindow& answer = recognized.front();
      right += !IsUnknown(answer.unknown_probability) && answer.labels.front().label == clip->label
                   ? 1
                   : 0;
      ++windows;
    }
  }
  return 100.0 * right / windows;
}

// Returns the mean marker error of predictions every half second, mm.
absl::StatusOr<double> PredictionError(const core::Model& model, const core::MarkerSet& set,
                                       const ClipSet& test, core::Method method) {
  core::PredictOptions options;
  options.method = method;
  options.history_seconds = kWindowSeconds;
  options.horizon_seconds = {kAhead_s};
  double sum = 0;
  int count = 0;
  for (const EvalClip* clip : test) {
    const double rate = clip->states.frame_rate_hz;
    const auto history = static_cast<int>(kWindowSeconds * rate);
    const auto ahead = static_cast<int>(kAhead_s * rate);
    MOTIONDB_ASSIGN_OR_RETURN(const core::MarkerMotion markers,
                              core::Resample(clip->markers, rate));
    const auto frames = static_cast<int>(markers.positions_m.rows());
    for (int first = 0; first + history + ahead <= frames;
         first += static_cast<int>(kForecastHop_s * rate)) {
      MOTIONDB_ASSIGN_OR_RETURN(
          const core::StateSequence past,
          core::ComputeStates(set, Slice(markers, first, history), clip->states.leg_length_m));
      MOTIONDB_ASSIGN_OR_RETURN(const core::Prediction prediction,
                                core::Predict(model, past, options));
      const Eigen::RowVectorXf off = prediction.horizons.front().marker_positions_m.transpose() -
                                     markers.positions_m.row(first + history - 1 + ahead);
      for (Eigen::Index m = 0; m < off.size() / 3; ++m) {
        sum += 1000.0 * static_cast<double>(off.segment<3>(3 * m).norm());
      }
      count += set.marker_count();
    }
  }
  return sum / count;
}

absl::StatusOr<Row> Measure(const Corpus& corpus, const Corruption& corruption,
                            core::GlitchPolicy policy, const char* policy_name) {
  MOTIONDB_ASSIGN_OR_RETURN(const Stored stored, Store(corpus, corruption, policy));
  MOTIONDB_ASSIGN_OR_RETURN(const core::Model model, BuildEvalModel(corpus.set, stored.set()));
  Row row{fmt::format("{}, {}", corruption.name, policy_name), {}, ""};
  for (const core::Method method : kMethods) {
    MOTIONDB_ASSIGN_OR_RETURN(row.figures.emplace_back(),
                              WindowAccuracy(model, corpus.database1_test, method));
  }
  for (const core::Method method : kMethods) {
    MOTIONDB_ASSIGN_OR_RETURN(row.figures.emplace_back(),
                              PredictionError(model, corpus.set, corpus.database1_test, method));
  }
  const core::FeatureScale& scale = model.scale();
  row.figures.insert(row.figures.end(), {static_cast<double>(stored.clips.size()),
                                         static_cast<double>(model.tree().total_node_count()),
                                         static_cast<double>(scale.divisor[0]),
                                         static_cast<double>(scale.divisor[3])});
  return row;
}

}  // namespace

absl::StatusOr<Tables> RunCorrupt(Studies& studies) {
  RecognitionStudy& study = studies.recognition;
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus* const corpus, study.LoadedCorpus());
  Table table{.title = "Database 1 with corrupt frames, by glitch policy",
              .columns = {{"windows correct, %"},
                          {"PAPER: windows"},
                          {"error at 0.4 s, mm"},
                          {"PAPER: error"},
                          {"clips", 0},
                          {"nodes", 0},
                          {"position scale", 4},
                          {"velocity scale", 4}}};
  constexpr int kRows = static_cast<int>(std::size(kCorruptions) * std::size(kPolicies));
  std::vector<absl::StatusOr<Row>> rows(kRows);
  study.ForEach("corrupt frames", kRows, [&](int i) {
    const auto& [policy, name] = kPolicies[i % std::size(kPolicies)];
    rows[i] = Measure(*corpus, kCorruptions[i / std::size(kPolicies)], policy, name);
  });
  for (const auto& row : rows) {
    MOTIONDB_RETURN_IF_ERROR(row.status());
    table.rows.push_back(*row);
  }
  table.notes.push_back(
      "One stored clip in twenty is corrupt: all its markers are 100 m away in one frame, or in 1 "
      "% of its frames. Windows of 0.4 s every 0.1 s, forecasts every 0.5 s of the clean test "
      "clips. Clean clips may have glitches too, so that reject stores fewer clips.");
  return Tables{table};
}

}  // namespace motiondb::tests
