// Measures the cost of filters: queries in 1 %, 10 % and 100 % of the clips of a large database,
// compared with the same queries in all clips. The runs alternate, each on one thread, in process.
// Masks are warm, as in a server that has answered a query with the filter. Results are medians of
// processor time. Also measures new labels of all clips, without a refit.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/estimation/estimate.h"
#include "core/format/marker_set_file.h"
#include "core/model/clip_mask.h"
#include "core/observe/observer.h"
#include "core/planning/plan.h"
#include "core/prediction/predict.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/varied_motion.h"
#include "tests/support/plan_goals.h"
#include "tests/support/real_data.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

constexpr std::uint64_t kFilterStoredSeed = 1;
constexpr std::uint64_t kFilterObservedSeed = 2;
constexpr double kMaxCost = 1.1;
constexpr double kMaxRelabel_ms = 300;
constexpr int kWindowFrames = 24;
constexpr std::array kShares = {0.01, 0.1, 1.0};

struct FilterOptions {
  VariedSize size;
  int windows = 48;
  int plans = 12;
  int jobs = 1;
};

using Mask = std::shared_ptr<const core::ClipMask>;
// A query of one window with a mask.
using MaskedQuery = std::function<absl::Status(int window, const Mask& mask)>;

struct FilterQuery {
  std::string name;
  int count = 0;  // of windows
  MaskedQuery run;
};

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

absl::StatusOr<core::Model> BuildVaried(const VariedSize& size, const core::ParallelFor& parallel) {
  auto clips = VariedClips(DataDir(), size, kFilterStoredSeed, parallel);
  if (!clips.ok()) return clips.status();
  core::BuildSettings settings;
  settings.frame_rate_hz = size.frame_rate_hz;
  auto model =
      core::BuildModel(settings, core::StandardScheme().set, *std::move(clips), parallel, {});
  if (!model.ok()) return model;
  auto calibration = core::CalibrateRecognition(*model, parallel, {});
  if (!calibration.ok()) return calibration.status();
  model->set_recognition(*std::move(calibration));
  return model;
}

// Returns windows of clips that are not stored.
absl::StatusOr<std::vector<core::StateSequence>> UnseenWindows(const FilterOptions& options,
                                                               const core::ParallelFor& parallel) {
  VariedSize size = options.size;
  size.clips = options.windows;
  size.frames = 120 * options.windows;
  auto clips = VariedClips(DataDir(), size, kFilterObservedSeed, parallel);
  if (!clips.ok()) return clips.status();
  std::vector<core::StateSequence> windows;
  for (const core::BuildInput& clip : *clips) {
    const int first = clip.states.frame_count() / 4;
    windows.push_back({clip.states.frame_rate_hz, clip.states.leg_length_m,
                       clip.states.states.middleRows(first, kWindowFrames),
                       clip.states.root_path.middleRows(first, kWindowFrames)});
  }
  return windows;
}

// Spreads the allowed clips evenly.
absl::StatusOr<Mask> MaskOfShare(const core::Model& model, double share) {
  std::vector<bool> allowed(model.clips().size());
  const auto step = static_cast<std::size_t>(1 / share);
  for (std::size_t c = 0; c < allowed.size(); c += step) allowed[c] = true;
  return core::ClipMask::Create(model, std::move(allowed));
}

std::vector<FilterQuery> QueriesOf(const core::Model& model,
                                   const std::vector<core::StateSequence>& windows,
                                   const std::vector<core::FloorPose>& goals) {
  const auto count = static_cast<int>(windows.size());
  std::vector<FilterQuery> queries;
  for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
    const char* const name = method == core::Method::kBest ? "best" : "paper";
    queries.push_back(
        {fmt::format("recognize 0.4 s, {}", name), count, [&, method](int w, const Mask& mask) {
           core::RecognizeOptions options;
           options.method = method;
           options.mask = mask;
           return core::Recognize(model, windows[w], options).status();
         }});
    queries.push_back(
        {fmt::format("predict, {}", name), count, [&, method](int w, const Mask& mask) {
           core::PredictOptions options;
           options.method = method;
           options.mask = mask;
           return core::Predict(model, windows[w], options).status();
         }});
  }
  queries.push_back({"estimate 0.4 s", count, [&](int w, const Mask& mask) {
                       core::EstimateOptions options;
                       options.search.mask = mask;
                       return core::Estimate(model, windows[w], options).status();
                     }});
  queries.push_back(
      {"observe 0.4 s, 12 answers", count, [&](int w, const Mask& mask) -> absl::Status {
         core::ObserverOptions options;
         options.mask = mask;
         const auto& set = core::StandardScheme().set;
         const auto observer = core::Observer::Create(model, core::StandardScheme(), set.markers,
                                                      model.settings().frame_rate_hz,
                                                      windows[w].leg_length_m, options);
         if (!observer.ok()) return observer.status();
         const core::FrameMatrix positions = core::WorldPositions(windows[w]);
         for (int t = 0; t < kWindowFrames; t += 2) {
           absl::Status status = (*observer)->Append(t, positions.middleRows(t, 2));
           if (status.ok()) status = (*observer)->Answer().status();
           if (!status.ok()) return status;
         }
         return absl::OkStatus();
       }});
  queries.push_back(
      {"plan to a goal", static_cast<int>(goals.size()), [&](int w, const Mask& mask) {
         core::PlanProblem problem;
         problem.goal = goals[w];
         problem.playable.mask = mask;
         return core::PlanMotion(model, core::StandardScheme(), problem).status();
       }});
  return queries;
}

absl::StatusOr<BenchTable> MeasureFilters(const FilterOptions& options) {
  const core::ParallelFor parallel = RunOnThreads(options.jobs);
  const auto model = BuildVaried(options.size, parallel);
  if (!model.ok()) return model.status();
  const auto windows = UnseenWindows(options, parallel);
  if (!windows.ok()) return windows.status();
  const auto goals = RandomGoals(options.plans, 1);

  std::vector<Mask> masks = {nullptr};
  for (const double share : kShares) {
    auto mask = MaskOfShare(*model, share);
    if (!mask.ok()) return mask.status();
    masks.push_back(*std::move(mask));
  }
  BenchTable table{"masks", {}, {}};
  for (const FilterQuery& query : QueriesOf(*model, *windows, goals)) {
    std::vector<std::vector<double>> ms(masks.size());
    for (int w = -1; w < query.count; ++w) {  // the first round warms the masks
      for (std::size_t m = 0; m < masks.size(); ++m) {
        const std::clock_t begin = std::clock();
        const absl::Status status = query.run(std::max(0, w), masks[m]);
        if (!status.ok()) return status;
        if (w >= 0)
          ms[m].push_back(1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
      }
    }
    for (std::size_t m = 1; m < masks.size(); ++m) {
      table.rows.push_back(RatioRow(
          fmt::format("{}, in {:.0f} % of the clips", query.name, 100 * kShares[m - 1]),
          MedianOf(ms[m]), "the same in all clips", MedianOf(ms[0]), "ms", AtMost(kMaxCost)));
    }
  }
  std::vector<double> relabel_ms;
  for (int round = 0; round < 5; ++round) {
    std::vector<core::ClipLabels> labels;
    for (const core::ModelClip& clip : model->clips()) {
      labels.push_back({clip.label() + fmt::format(" {}", round), clip.subject});
    }
    const std::clock_t begin = std::clock();
    const auto relabelled = model->WithLabels(std::move(labels));
    if (!relabelled.ok()) return relabelled.status();
    relabel_ms.push_back(1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  table.rows.push_back(RatioRow("new labels for all clips", MedianOf(relabel_ms), "limit",
                                kMaxRelabel_ms, "ms", AtMost(1)));
  table.notes.push_back(fmt::format(
      "masks: {}, {} frames in {} clips; {} windows of clips that are not stored, {} "
      "goals; medians of processor time, all on one thread",
      kVariedMotion, model->frame_count(), model->clips().size(), options.windows, options.plans));
  return table;
}

int FilterMain(int argc, char** argv) {
  BenchProgram program("Measures the cost of filtered queries.", "motiondb_bench_masks");
  FilterOptions options;
  program.AddSize(options.size);
  program.app()
      .add_option("--windows", options.windows, "Windows of each query")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  program.app()
      .add_option("--plans", options.plans, "Goals to plan to")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  program.AddJobs(options.jobs, "Threads of the build");
  return program.Run(argc, argv, [&] { return MeasureFilters(options); });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::FilterMain(argc, argv); }
