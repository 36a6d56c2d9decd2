// Compares segment search and the paper's random sampling on plans to seeded random goals in
// database2: success rate, search time on one thread, and quality of the motion relative to the
// stored clips. Goals are scored once; nothing is tuned on them.

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdio>
#include <string>

#include "core/format/marker_set_file.h"
#include "core/planning/plan.h"
#include "tests/support/plan_goals.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests {
namespace {

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

struct Tally {
  int outcomes[4] = {};
  int arrived = 0;  // according to the search
  std::vector<double> search_ms, total_ms, duration_s, error_m, slide, penetration, jerk;
};

Tally Run(const core::Model& model, core::PlanMethod method,
          const std::vector<core::FloorPose>& goals,
          const std::shared_ptr<const core::Skeleton>& skeleton) {
  Tally tally;
  for (const core::FloorPose& goal : goals) {
    core::PlanProblem problem{.goal = goal, .method = method, .skeleton = skeleton};
    const auto begin = std::chrono::steady_clock::now();
    const auto elapsed_ms = [&] {
      return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
          .count();
    };
    const auto answer =
        core::PlanMotion(model, core::StandardScheme(), problem,
                         {.search_over = [&] { tally.search_ms.push_back(elapsed_ms()); }});
    if (!answer.ok()) {
      std::printf("failed: %s\n", answer.status().ToString().c_str());
      continue;
    }
    tally.total_ms.push_back(elapsed_ms());
    ++tally.outcomes[static_cast<int>(answer->outcome)];
    tally.arrived += answer->effort.improvements > 0;
    if (answer->motions.empty()) continue;
    const core::PlanQuality& quality = answer->motions.front().quality;
    tally.duration_s.push_back(quality.duration_seconds);
    tally.error_m.push_back(quality.position_error_m);
    tally.slide.push_back(quality.motion.foot_slide_cm_per_s);
    tally.penetration.push_back(quality.motion.floor_penetration_cm);
    tally.jerk.push_back(quality.motion.peak_marker_jerk_m_s3);
  }
  return tally;
}

void Print(const char* what, const Tally& a, const Tally& b, std::vector<double> Tally::*figure,
           double share) {
  std::printf("| %-36s | %15.3f | %15.3f |\n", what, Quantile(a.*figure, share),
              Quantile(b.*figure, share));
}

void PrintTable(const Tally& search, const Tally& sampling, std::size_t goals) {
  std::printf("| %-36s | %15s | %15s |\n", "", "segment search", "random sampling");
  std::printf("|--------------------------------------|-----------------|-----------------|\n");
  const char* outcomes[] = {"EXACT, %", "APPROXIMATE, %", "UNREACHABLE, %"};
  for (int i = 0; i < 3; ++i) {
    std::printf("| %-36s | %15.1f | %15.1f |\n", outcomes[i],
                100.0 * search.outcomes[i] / static_cast<double>(goals),
                100.0 * sampling.outcomes[i] / static_cast<double>(goals));
  }
  std::printf("| %-36s | %15.1f | %15.1f |\n", "arrived according to the search, %",
              100.0 * search.arrived / static_cast<double>(goals),
              100.0 * sampling.arrived / static_cast<double>(goals));
  Print("search, ms, median", search, sampling, &Tally::search_ms, 0.5);
  Print("search, ms, 95th percentile", search, sampling, &Tally::search_ms, 0.95);
  Print("search, ms, largest", search, sampling, &Tally::search_ms, 1);
  Print("search, synthesis and IK, ms, median", search, sampling, &Tally::total_ms, 0.5);
  Print("search, synthesis and IK, ms, p95", search, sampling, &Tally::total_ms, 0.95);
  Print("distance from the goal, m, median", search, sampling, &Tally::error_m, 0.5);
  Print("distance from the goal, m, 95th pc.", search, sampling, &Tally::error_m, 0.95);
  Print("duration, s, median", search, sampling, &Tally::duration_s, 0.5);
  Print("foot slide, cm/s, median", search, sampling, &Tally::slide, 0.5);
  Print("floor penetration, cm, median", search, sampling, &Tally::penetration, 0.5);
  Print("peak marker jerk, m/s^3, median", search, sampling, &Tally::jerk, 0.5);
}

}  // namespace

TEST_CASE("Plan benchmark") {
  MOTIONDB_REQUIRE_DATA();
  const auto list = DataDir() / "sets" / "database2.tsv";
  const core::Model model = BuildFromList(list, {});
  const core::MotionFile first = LoadMotion(ReadList(list).front().path);
  const auto skeleton = std::get<core::JointMotion>(first.motion).skeleton;
  const auto goals = RandomGoals(500, 2026);
  std::printf("%zu goals, seed 2026, %d frames in %zu clips at 60 Hz, skeleton %s, one thread\n\n",
              goals.size(), model.frame_count(), model.clips().size(), skeleton->name().c_str());
  const Tally search = Run(model, core::PlanMethod::kSegmentSearch, goals, skeleton);
  const Tally sampling = Run(model, core::PlanMethod::kRandomSampling, goals, skeleton);
  PrintTable(search, sampling, goals.size());
}

}  // namespace motiondb::tests
