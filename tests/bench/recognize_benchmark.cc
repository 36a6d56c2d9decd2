// Measures recognition and search of 0.4 s of motion in a large database, in process, compared with
// FAISS's exact windowed search over the same frames and with recognition in 20 similar clips.
// Windows are from varied clips of another seed, not in the database. The methods alternate, each
// on one thread, with and without AVX2. Results are medians of processor time.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/format/marker_set_file.h"
#include "core/recognition/find_motion.h"
#include "core/recognition/recognize.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/varied_motion.h"
#include "tests/bench/window_search.h"
#include "tests/support/real_data.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

constexpr double kWindowSeconds = 0.4;
constexpr int kFewClips = 20;
constexpr std::uint64_t kStoredSeed = 1;
constexpr std::uint64_t kObservedSeed = 2;

struct Options {
  VariedSize size;
  int windows = 64;
  int searches = 9;  // windows also searched by FAISS
  int jobs = 1;
};

// Returns the processor time of all threads, s: independent of other load on the machine.
double ProcessorSeconds(const auto& work) {
  const std::clock_t begin = std::clock();
  work();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

absl::StatusOr<core::Model> Build(const VariedSize& size, const core::ParallelFor& parallel) {
  auto clips = VariedClips(DataDir(), size, kStoredSeed, parallel);
  if (!clips.ok()) return clips.status();
  core::BuildSettings settings;
  settings.frame_rate_hz = size.frame_rate_hz;
  auto model =
      core::BuildModel(settings, core::StandardScheme().set, *std::move(clips), parallel, {});
  if (!model.ok()) return model;
  // Calibrated as in a server: without calibration, familiarity visits every node.
  auto calibration = core::CalibrateRecognition(*model, parallel, {});
  if (!calibration.ok()) return calibration.status();
  model->set_recognition(*std::move(calibration));
  return model;
}

struct Window {
  core::StateSequence states;
  std::string label;
};

absl::StatusOr<std::vector<Window>> Windows(const VariedSize& stored, int count,
                                            const core::ParallelFor& parallel) {
  VariedSize size = stored;
  size.clips = count;
  size.frames = 120 * count;
  auto clips = VariedClips(DataDir(), size, kObservedSeed, parallel);
  if (!clips.ok()) return clips.status();
  const auto length = static_cast<int>(kWindowSeconds * size.frame_rate_hz + 0.5);
  std::vector<Window> windows;
  for (const core::BuildInput& clip : *clips) {
    const int first = clip.states.frame_count() / 4;
    Window& window = windows.emplace_back();
    window.states.frame_rate_hz = clip.states.frame_rate_hz;
    window.states.leg_length_m = clip.states.leg_length_m;
    window.states.states = clip.states.states.middleRows(first, length);
    window.states.root_path = clip.states.root_path.middleRows(first, length);
    window.label = clip.label();
  }
  return windows;
}

// Milliseconds of each window's recognition, and the number of correct labels.
struct Answers {
  std::vector<double> ms;
  int right = 0;
};

absl::Status Recognize(const core::Model& model, core::Method method, const Window& window,
                       Answers& answers) {
  core::RecognizeOptions options;
  options.method = method;
  options.window_seconds = kWindowSeconds;
  absl::StatusOr<std::vector<core::RecognizedWindow>> recognized;
  answers.ms.push_back(
      1e3 * ProcessorSeconds([&] { recognized = core::Recognize(model, window.states, options); }));
  if (!recognized.ok()) return recognized.status();
  answers.right += recognized->front().labels.front().label == window.label;
  return absl::OkStatus();
}

// Milliseconds of each search for similar parts.
absl::Status Find(const core::Model& model, const Window& window, bool exhaustive,
                  std::vector<double>& ms, std::vector<core::MotionMatch>& matches) {
  absl::StatusOr<std::vector<core::MotionMatch>> found;
  ms.push_back(1e3 * ProcessorSeconds([&] {
                 auto motion = core::PartOfObservation(model, window.states, {});
                 found = motion.ok() ? core::FindMotion(model, *std::move(motion),
                                                        {.exhaustive = exhaustive})
                                     : motion.status();
               }));
  if (found.ok()) matches = *std::move(found);
  return found.status();
}

// Returns how many of the matches of the exhaustive search the other one has.
int CountFound(const std::vector<core::MotionMatch>& all,
               const std::vector<core::MotionMatch>& found) {
  return static_cast<int>(std::ranges::count_if(all, [&](const core::MotionMatch& match) {
    return std::ranges::any_of(found, [&](const core::MotionMatch& other) {
      return other.clip == match.clip && other.first_frame == match.first_frame;
    });
  }));
}

void Search(const core::Model& model, const Window& window, Answers& answers) {
  core::FrameMatrix frames = window.states.states;
  model.scale().Apply(frames);
  NearestWindow nearest;
  answers.ms.push_back(1e3 * ProcessorSeconds([&] {
                         nearest = FindNearestWindow(model.states(), model.clips(), frames,
                                                     core::RunSerially);
                       }));
  answers.right += model.clips()[nearest.clip].label() == window.label;
}

absl::StatusOr<BenchTable> Run(const Options& options) {
  const core::ParallelFor parallel = RunOnThreads(options.jobs);
  VariedSize few_size = options.size;
  few_size.clips = kFewClips;
  few_size.frames = options.size.frames / options.size.clips * kFewClips;
  const auto few = Build(few_size, parallel);
  if (!few.ok()) return few.status();
  absl::StatusOr<core::Model> many;
  const double build_seconds = ProcessorSeconds([&] { many = Build(options.size, parallel); });
  if (!many.ok()) return many.status();
  fmt::print(stderr, "{} clips, {} frames: generated and built in {:.1f} s processor time\n",
             options.size.clips, options.size.frames, build_seconds);
  const auto windows = Windows(options.size, options.windows, parallel);
  if (!windows.ok()) return windows.status();

  constexpr core::Method kMethods[] = {core::Method::kBest, core::Method::kPaper};
  Answers in_many[2], in_few[2], searched;
  std::vector<double> finds, exhaustive;
  int found_matches = 0, all_matches = 0;
  for (int w = 0; w < options.windows; ++w) {
    const Window& window = (*windows)[w];
    for (int m = 0; m < 2; ++m) {
      absl::Status status = Recognize(*many, kMethods[m], window, in_many[m]);
      status.Update(Recognize(*few, kMethods[m], window, in_few[m]));
      if (!status.ok()) return status;
    }
    std::vector<core::MotionMatch> matches;
    if (absl::Status status = Find(*many, window, false, finds, matches); !status.ok()) {
      return status;
    }
    if (w >= options.searches) continue;
    Search(*many, window, searched);
    std::vector<core::MotionMatch> all;
    if (absl::Status status = Find(*many, window, true, exhaustive, all); !status.ok()) {
      return status;
    }
    found_matches += CountFound(all, matches);
    all_matches += static_cast<int>(all.size());
  }

  BenchTable table{"recognition", {}, {}};
  const std::string size = fmt::format("{} clips", options.size.clips);
  for (int m = 0; m < 2; ++m) {
    const std::string what =
        fmt::format("recognize 0.4 s in {}, {}", size, m == 0 ? "best" : "paper");
    const double ours = Median(in_many[m].ms);
    table.rows.push_back(SpeedupRow(what, ours, "FAISS exact windowed search", Median(searched.ms),
                                    "ms", AtLeast(50)));
    table.rows.push_back(RatioRow(what, ours, fmt::format("the same in {} clips", kFewClips),
                                  Median(in_few[m].ms), "ms", AtMost(5)));
  }
  table.rows.push_back(SpeedupRow(fmt::format("find 0.4 s in {}", size), Median(finds),
                                  "FAISS exact windowed search", Median(searched.ms), "ms",
                                  AtLeast(14)));
  table.notes.push_back(
      fmt::format("recognition: find has {} of the {} matches of a search through all clips, which "
                  "takes {:.0f} "
                  "ms; both follow the motion at other speeds, FAISS does not",
                  found_matches, all_matches, Median(exhaustive)));
  table.notes.push_back(fmt::format(
      "recognition: {}, {} frames of {} numbers in {} ({} frames in {} clips); {} windows of clips "
      "that are not stored, medians of processor time, all on one thread",
      kVariedMotion, many->frame_count(), many->states().cols(), size, few->frame_count(),
      kFewClips, options.windows));
  table.notes.push_back(
      fmt::format("recognition: FAISS's distances of all stored frames to all of the window's "
                  "(pairwise_L2sqr), summed along the diagonals; {} windows",
                  searched.ms.size()));
  table.notes.push_back(fmt::format(
      "recognition: right labels: best {}/{}, paper {}/{}, FAISS {}/{}", in_many[0].right,
      options.windows, in_many[1].right, options.windows, searched.right, searched.ms.size()));
  return table;
}

int Main(int argc, char** argv) {
  BenchProgram program("Measures recognition in a large database.", "motiondb_bench_recognize");
  Options options;
  program.AddSize(options.size);
  program.app()
      .add_option("--windows", options.windows, "Windows to recognize")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  program.AddJobs(options.jobs, "Threads of the build");
  return program.Run(argc, argv, [&] { return Run(options); });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
