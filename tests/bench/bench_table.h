// The result of a benchmark: rows that compare a measurement with a peer or a limit of the same
// run. Written as a Markdown table and as JSON; motiondb_bench_summary joins the JSON files.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::tests {

// The required ratio of a row. Without a limit the row is only reported.
struct Bar {
  enum class Kind { kNone, kAtLeast, kAtMost };
  Kind kind = Kind::kNone;
  double limit = 0;
};

inline Bar AtLeast(double limit) { return {Bar::Kind::kAtLeast, limit}; }
inline Bar AtMost(double limit) { return {Bar::Kind::kAtMost, limit}; }
inline Bar NoBar() { return {}; }

struct BenchRow {
  std::string name;     // the measurement: "recognize 0.4 s, 2000 clips"
  double ours = 0;      // in `unit`
  std::string against;  // the peer or the limit: "FAISS exact windowed search"
  double theirs = 0;    // in `unit`
  std::string unit;     // of both: "ms", "MB/s"
  double ratio = 0;     // compared with the bar, e.g. how many times faster
  Bar bar;
  std::string note;  // why a bar is missed, or other remarks; may be empty

  // Returns whether the bar is met; nullopt without a bar. A non-finite ratio meets no bar.
  std::optional<bool> met() const;
};

// Returns a row of times (less is better): ratio = theirs / ours.
BenchRow SpeedupRow(std::string name, double ours, std::string against, double theirs,
                    std::string unit, Bar bar);
// Returns a row of costs, with ratio = ours / theirs. Rates (more is better) are such rows with a
// bar AtLeast.
BenchRow RatioRow(std::string name, double ours, std::string against, double theirs,
                  std::string unit, Bar bar);

struct BenchTable {
  std::string title;  // of the benchmark: "parsing"
  std::vector<BenchRow> rows;
  std::vector<std::string> notes;  // the data, the machine, how the peer works
};

// Returns Markdown: a table with aligned columns, the notes, and the notes of the rows with their
// names.
std::string ToMarkdown(const BenchTable& table);

// Returns {"title", "notes", "rows": [{"name", "ours", "unit", "against", "theirs", "ratio", "bar",
// "met", "note"}]}. bar is {"at_least": x}, {"at_most": x} or null; met is null without a bar.
nlohmann::json ToJson(const BenchTable& table);

// Parses the result of ToJson. INVALID_ARGUMENT if the value does not have that form.
absl::StatusOr<BenchTable> FromJson(const nlohmann::json& json);

// Prints the table and, if `json_file` is not empty, writes it there. Returns the exit code: 0,
// also if bars are missed; 1 if the file cannot be written.
int Finish(const BenchTable& table, const std::string& json_file);

}  // namespace motiondb::tests
