// What a benchmark found out: rows that set one of our figures beside a peer's or a limit's from
// the same run, as a Markdown table for people and JSON for programs. All benchmark programs use
// it, and motiondb_bench_summary puts their files together. Plain values.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::tests {

// What a row's ratio is to reach. Without a limit the row is only reported.
struct Bar {
  enum class Kind { kNone, kAtLeast, kAtMost };
  Kind kind = Kind::kNone;
  double limit = 0;
};

inline Bar AtLeast(double limit) { return {Bar::Kind::kAtLeast, limit}; }
inline Bar AtMost(double limit) { return {Bar::Kind::kAtMost, limit}; }
inline Bar Reported() { return {}; }

struct BenchRow {
  std::string name;     // what was measured: "recognize 0.4 s, 2000 clips"
  double ours = 0;      // in `unit`
  std::string against;  // the peer or the limit: "FAISS exact windowed search"
  double theirs = 0;    // in `unit`
  std::string unit;     // of both: "ms", "MB/s"
  double ratio = 0;     // what the bar is about, e.g. how many times faster
  Bar bar;
  std::string note;  // why a bar is missed, or what a reader must know; may be empty

  // Whether the bar is met; none where there is no bar. A ratio that is not finite meets none.
  std::optional<bool> met() const;
};

// A row of times (less is better): the ratio is how many times ours goes into theirs.
BenchRow TimesFaster(std::string name, double ours, std::string against, double theirs,
                     std::string unit, Bar bar);
// A row of costs that may be some times the other's: the ratio is ours over theirs. Rates (more is
// better) are such rows too, with a bar AtLeast.
BenchRow TimesTheirs(std::string name, double ours, std::string against, double theirs,
                     std::string unit, Bar bar);

struct BenchTable {
  std::string title;  // of the program: "parsing"
  std::vector<BenchRow> rows;
  std::vector<std::string> notes;  // the data, the machine, what the peer does
};

// Markdown: a table with aligned columns, then the notes, and the rows' notes under their names.
std::string ToMarkdown(const BenchTable& table);

// {"title", "notes", "rows": [{"name", "ours", "unit", "against", "theirs", "ratio", "bar", "met",
// "note"}]}; bar is {"at_least": x}, {"at_most": x} or null, met null without a bar.
nlohmann::json ToJson(const BenchTable& table);

// The way back. INVALID_ARGUMENT if the value is not of that form.
absl::StatusOr<BenchTable> FromJson(const nlohmann::json& json);

// Prints the table and, where `json_file` is not empty, writes it there. The exit status of a
// program that ends with this: 0, also where bars are missed; 1 if the file cannot be written.
int Finish(const BenchTable& table, const std::string& json_file);

}  // namespace motiondb::tests
