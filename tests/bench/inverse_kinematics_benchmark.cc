// Measures inverse kinematics on one core, frames per second: from the markers of recorded clips to
// joint angles of the CMU skeleton (62 degrees of freedom, 34 markers).
#include <benchmark/benchmark.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/format/marker_set_file.h"
#include "core/format/motion_file.h"
#include "core/kinematics/inverse_kinematics.h"
#include "tests/support/real_data.h"

namespace motiondb::tests {
namespace {

struct Clip {
  core::MarkerKinematics kinematics;
  core::MarkerMotion markers;
};

// Exits if a file cannot be read.
Clip ReadClip(const std::filesystem::path& amc) {
  const std::string skeleton =
      ReadFile(amc.parent_path() / (amc.parent_path().filename().string() + ".asf"));
  const std::string bytes = ReadFile(amc);
  const core::MotionFile file = core::ReadMotionFile(core::FileFormat::kAmc, {"clip.amc", bytes},
                                                     core::SourceFile{"skeleton.asf", skeleton})
                                    .value();
  const core::MarkerScheme& scheme = core::StandardScheme();
  return {core::MarkerKinematics::Create(scheme, std::get<core::JointMotion>(file.motion).skeleton)
              .value(),
          core::ApplyScheme(scheme, file.motion).value()};
}

void SolveClip(benchmark::State& state, const std::string& path, const core::IkOptions& options) {
  const Clip clip = ReadClip(DataDir() / path);
  for (auto _ : state) {
    benchmark::DoNotOptimize(core::SolveInverseKinematics(clip.kinematics, clip.markers, options));
  }
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(clip.markers.positions_m.rows()),
                         benchmark::Counter::kIsIterationInvariantRate);
}

void SearchFirstFrame(benchmark::State& state, const std::string& path) {
  const Clip clip = ReadClip(DataDir() / path);
  for (auto _ : state) {
    core::PoseTracker tracker(clip.kinematics, {});
    benchmark::DoNotOptimize(tracker.Follow(clip.markers.positions_m.row(0)));
  }
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) {
  using namespace motiondb;
  benchmark::Initialize(&argc, argv);
  if (!std::filesystem::exists(tests::DataDir() / "index.tsv")) {
    std::printf("skipped: no recorded motion in %s\n", tests::DataDir().c_str());
    return 0;
  }
  for (const std::string path : {"cmu/16/16_18.amc", "cmu/16/16_01.amc", "cmu/09/09_12.amc"}) {
    benchmark::RegisterBenchmark(("limits/" + path).c_str(), tests::SolveClip, path,
                                 core::IkOptions{})
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("no_limits/" + path).c_str(), tests::SolveClip, path,
                                 core::IkOptions{.respect_limits = false})
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("first_frame/" + path).c_str(), tests::SearchFirstFrame, path)
        ->Unit(benchmark::kMillisecond);
  }
  benchmark::RunSpecifiedBenchmarks();
}
