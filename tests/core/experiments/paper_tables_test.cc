// The paper's databases, approximated by public motion, with the paper's numbers for comparison.
#include <catch2/catch.hpp>
#include <cstdio>
#include <map>

#include "core/recognition/recognize.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::paper_tables_test {
namespace {

void PrintRow(const char* what, int ours, int paper) {
  std::printf("  %-24s %8d %8d\n", what, ours, paper);
}

}  // namespace

TEST_CASE("Database 2 at 120 Hz has the shape of the paper's Table I", "[experiment][data]") {
  MOTIONDB_REQUIRE_DATA();
  core::BuildSettings settings;
  settings.frame_rate_hz = 120;
  const core::Model model = BuildFromList(DataDir() / "sets" / "database2.tsv", settings);
  const core::Tree& tree = model.tree();
  const int bottom = tree.node_count(tree.layer_count());
  std::printf("Table I, database 2              ours    paper\n");
  PrintRow("frames", model.frame_count(), 11456);
  PrintRow("layers", tree.layer_count(), 16);
  PrintRow("nodes", tree.total_node_count(), 1527);
  PrintRow("nodes in bottom layer", bottom, 205);
  CHECK(tree.layer_count() >= 16 / 2);
  CHECK(tree.layer_count() <= 16 * 2);
  CHECK(bottom > 205 / 2);
  CHECK(bottom < 205 * 2);
  CHECK(tree.total_node_count() > 1527 / 3);
  CHECK(tree.total_node_count() < 1527 * 2);
}

TEST_CASE("Database 1: 0.4-s windows of unseen clips are recognized", "[experiment][data]") {
  MOTIONDB_REQUIRE_DATA();
  const core::Model model = BuildFromList(DataDir() / "sets" / "database1.train.tsv", {});
  std::map<std::string, std::pair<int, int>> by_label;  // correct, total
  int right = 0;
  int all = 0;
  for (const ListedClip& clip : ReadList(DataDir() / "sets" / "database1.test.tsv")) {
    const auto windows = core::Recognize(
        model, LoadStates(clip.path, model.settings().frame_rate_hz, core::kObservation), {});
    REQUIRE(windows.ok());
    for (const core::RecognizedWindow& window : *windows) {
      const bool hit = window.labels.front().label == clip.label;
      right += hit;
      ++all;
      by_label[clip.label].first += hit;
      ++by_label[clip.label].second;
    }
  }
  std::printf("Database 1, 0.4-s windows recognized correctly: %d of %d (%.1f %%)\n", right, all,
              100.0 * right / all);
  for (const auto& [label, count] : by_label) {
    std::printf("  %-6s %4d of %4d (%.1f %%)\n", label.c_str(), count.first, count.second,
                100.0 * count.first / count.second);
  }
  CHECK(right >= 0.93 * all);
}

}  // namespace motiondb::tests::paper_tables_test
