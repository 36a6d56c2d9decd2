// Measures the build of a tree of 10,000, 100,000 and 1,000,000 frames, compared with: the memory
// limit, one streaming read of every node tested for a split, at the bandwidth of all threads in
// the same run; FAISS's k-means with as many clusters as the tree has leaves; and the same build
// without AVX2. Wall time. Bandwidth is measured before and after each build.
#include <faiss/Clustering.h>
#include <faiss/IndexFlat.h>
#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/tree/node_gaussians.h"
#include "core/tree/tree_builder.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/varied_motion.h"
#include "tests/support/real_data.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr int kFramesPerClip = 500;
constexpr int kMinFrames = 16;
constexpr double kStreamedBytes = 1 << 28;  // far larger than any cache

struct Options {
  std::vector<int> frames = {10'000, 100'000, 1'000'000};
  int builds = 3;                 // the median is reported
  int max_clustered = 1'000'000;  // frames; k-means costs frames times clusters
  int jobs = 1;
};

double Seconds(const auto& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Measures the read bandwidth of all threads together, bytes per second; each reads its own part.
class Bandwidth {
 public:
  Bandwidth(int jobs, const core::ParallelFor& parallel)
      : jobs_(jobs),
        parallel_(parallel),
        numbers_(
            core::FrameMatrix::Ones(jobs, static_cast<Eigen::Index>(kStreamedBytes) / 4 / jobs)),
        sums_(static_cast<std::size_t>(jobs)) {}

  void Measure() {
    const double seconds =
        Seconds([&] { parallel_(jobs_, [&](int j) { sums_[j] = numbers_.row(j).sum(); }); });
    rates_.push_back(static_cast<double>(numbers_.size()) * sizeof(float) / seconds);
  }
  double median() const { return Median(rates_); }
  // Used, so that the compiler cannot remove the reads.
  float sum() const { return *std::max_element(sums_.begin(), sums_.end()); }

 private:
  int jobs_;
  const core::ParallelFor& parallel_;
  core::FrameMatrix numbers_;
  std::vector<float> sums_;
  std::vector<double> rates_;
};

struct Built {
  core::Tree tree;
  double seconds = 0;
  double fit_seconds = 0;  // of the nodes' Gaussians
  double frames_read = 0;  // of all nodes tested for a split
  int leaves = 0;
};

Built Build(const core::FrameMatrix& states, int builds, Bandwidth& bandwidth,
            const core::ParallelFor& parallel) {
  Built built;
  std::vector<double> seconds;
  const auto build = [&] { built.tree = *core::BuildTree(states, kMinFrames, parallel); };
  for (int b = 0; b < builds; ++b) {
    for (int i = 0; i < 3; ++i) bandwidth.Measure();
    seconds.push_back(Seconds(build));
    for (int i = 0; i < 3; ++i) bandwidth.Measure();
  }
  built.seconds = Median(seconds);
  built.fit_seconds = Seconds([&] { core::NodeGaussians::Fit(built.tree, states, parallel); });
  for (const core::Branch& branch : built.tree.branches()) {
    const int frames = branch.end - branch.begin;
    if (frames >= 2 * kMinFrames) built.frames_read += frames;
    built.leaves += branch.left < 0;
  }
  return built;
}

// FAISS's k-means with its own 25 iterations. All cost the same, so only a few run for large
// inputs.
struct Clustered {
  int timed = 0;       // iterations that were run
  double seconds = 0;  // extrapolated to all 25
};

Clustered Cluster(const core::FrameMatrix& states, int clusters) {
  constexpr double kDistances = 1e9;  // about a minute of one core
  faiss::ClusteringParameters parameters;
  const int all = parameters.niter;
  const double each = static_cast<double>(states.rows()) * clusters;
  Clustered clustered{static_cast<int>(std::clamp(kDistances / each, 1.0, 1.0 * all)), 0};
  parameters.niter = clustered.timed;
  parameters.max_points_per_centroid = static_cast<int>(states.rows());  // all frames
  parameters.min_points_per_centroid = 1;
  faiss::Clustering clustering(static_cast<int>(states.cols()), clusters, parameters);
  faiss::IndexFlatL2 index(states.cols());
  const double seconds = Seconds([&] { clustering.train(states.rows(), states.data(), index); });
  clustered.seconds = seconds * all / clustered.timed;
  return clustered;
}

std::string Thousands(int frames) { return fmt::format("{}k frames", frames / 1000); }

absl::StatusOr<BenchTable> Run(const Options& options) {
  const core::ParallelFor parallel = RunOnThreads(options.jobs);
  omp_set_num_threads(options.jobs);
  Bandwidth bandwidth(options.jobs, parallel);
  BenchTable table{"tree build", {}, {}};
  std::vector<double> read_nanoseconds;
  for (const int frames : options.frames) {
    VariedSize size;
    size.frames = frames;
    size.clips = std::max(1, frames / kFramesPerClip);
    const auto states = VariedStates(DataDir(), size, kSeed, parallel);
    if (!states.ok()) return states.status();
    const Built built = Build(*states, options.builds, bandwidth, parallel);
    const double bytes = built.frames_read * static_cast<double>(states->cols()) * sizeof(float);
    table.rows.push_back(RatioRow(fmt::format("tree build, {}", Thousands(frames)),
                                  1e3 * built.seconds, "one streaming read of each tested node",
                                  1e3 * bytes / bandwidth.median(), "ms", AtMost(15)));
    read_nanoseconds.push_back(1e9 * built.seconds / built.frames_read);
    table.notes.push_back(fmt::format(
        "tree build, {}: {} layers, {} leaves; each frame is tested {:.1f} times, {:.0f} ns per "
        "frame and test; node statistics {:.0f} ms",
        Thousands(frames), built.tree.layer_count(), built.leaves, built.frames_read / frames,
        read_nanoseconds.back(), 1e3 * built.fit_seconds));
    fmt::print(stderr, "{}\n", table.notes.back());
    if (frames > options.max_clustered) continue;
    const Clustered clustered = Cluster(*states, built.leaves);
    table.rows.push_back(
        SpeedupRow(fmt::format("tree build, {}", Thousands(frames)), 1e3 * built.seconds,
                   fmt::format("FAISS k-means, {} clusters, 25 iterations ({} timed)", built.leaves,
                               clustered.timed),
                   1e3 * clustered.seconds, "ms", AtLeast(20)));
  }
  for (std::size_t i = 1; i < options.frames.size(); ++i) {
    table.rows.push_back(RatioRow(fmt::format("frame and test, {}", Thousands(options.frames[i])),
                                  read_nanoseconds[i], Thousands(options.frames[i - 1]),
                                  read_nanoseconds[i - 1], "ns",
                                  options.frames[i] == 1'000'000 ? AtMost(1.3) : NoBar()));
  }
  table.notes.push_back(fmt::format(
      "tree build: {}, {} numbers per frame, at least {} frames per node; {} threads, median of {} "
      "builds; streaming read: {:.1f} GB/s (median over the run, checksum {:.0f})",
      kVariedMotion, 204, kMinFrames, options.jobs, options.builds, bandwidth.median() / 1e9,
      bandwidth.sum()));
  table.notes.push_back(
      "tree build: k-means over all frames, with FAISS's own 25 iterations; all cost the same, so "
      "for large inputs a few are timed and the rest is extrapolated");
  return table;
}

int Main(int argc, char** argv) {
  BenchProgram program("Measures the build of the tree.", "motiondb_bench_tree");
  Options options;
  program.app()
      .add_option("--frames", options.frames, "Frames of each tree, ascending")
      ->delimiter(',')
      ->check(CLI::Range(1000, 100'000'000))
      ->capture_default_str();
  program.app()
      .add_option("--builds", options.builds, "Builds per tree")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  program.app()
      .add_option("--most-clustered", options.max_clustered, "Maximum frames for k-means")
      ->capture_default_str();
  program.AddJobs(options.jobs, "Threads");
  return program.Run(argc, argv, [&] { return Run(options); });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
