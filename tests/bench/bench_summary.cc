// motiondb_bench_summary joins the tables of benchmark programs into one table and one JSON file.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "tests/bench/bench_table.h"

namespace motiondb::tests {
namespace {

absl::StatusOr<nlohmann::json> ReadJson(const std::string& path) {
  std::ifstream file(path);
  if (!file) return core::NotFound("{}: cannot read the file", path);
  nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
  if (json.is_discarded()) return core::InvalidArgument("{}: expected JSON", path);
  return json;
}

// Joins all rows in the order of the files; drops equal notes.
absl::StatusOr<BenchTable> Join(const std::vector<std::string>& paths) {
  BenchTable joined{"Benchmarks", {}, {}};
  std::set<std::string> seen;
  for (const std::string& path : paths) {
    MOTIONDB_ASSIGN_OR_RETURN(const nlohmann::json json, ReadJson(path));
    MOTIONDB_ASSIGN_OR_RETURN(BenchTable table, FromJson(json));
    for (BenchRow& row : table.rows) joined.rows.push_back(std::move(row));
    for (std::string& note : table.notes) {
      if (seen.insert(note).second) joined.notes.push_back(std::move(note));
    }
  }
  return joined;
}

int Main(int argc, char** argv) {
  CLI::App app("Joins the tables of benchmark programs.", "motiondb_bench_summary");
  std::vector<std::string> paths;
  std::string json;
  app.add_option("tables", paths, "JSON files of benchmark programs")->required();
  app.add_option("--json", json, "Also write the table to this file")->type_name("FILE");
  CLI11_PARSE(app, argc, argv);
  const absl::StatusOr<BenchTable> table = Join(paths);
  if (table.ok()) return Finish(*table, json);
  fmt::print(stderr, "motiondb_bench_summary: {}\n", std::string(table.status().message()));
  return 1;
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
