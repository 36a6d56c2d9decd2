#include "tests/bench/bench_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::tests {
namespace {

constexpr int kColumns = 7;
constexpr int kFirstNumber = 2;  // right-aligned from this column
using Line = std::array<std::string, kColumns>;

// Returns the number with three significant digits, without an exponent if possible.
std::string Figure(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (size >= 1e7 || (size > 0 && size < 1e-3)) return fmt::format("{:.2e}", value);
  return fmt::format("{:.{}f}", value, size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3);
}

std::string BarText(const Bar& bar) {
  switch (bar.kind) {
    case Bar::Kind::kAtLeast:
      return fmt::format("at least {:g}x", bar.limit);
    case Bar::Kind::kAtMost:
      return fmt::format("at most {:g}x", bar.limit);
    case Bar::Kind::kNone:
      break;
  }
  return "reported";
}

Line ToLine(const BenchRow& row) {
  const std::optional<bool> met = row.met();
  return {row.name,
          row.against,
          fmt::format("{} {}", Figure(row.ours), row.unit),
          fmt::format("{} {}", Figure(row.theirs), row.unit),
          std::isfinite(row.ratio) ? fmt::format("{}x", Figure(row.ratio)) : "-",
          BarText(row.bar),
          !met   ? ""
          : *met ? "met"
                 : "MISSED"};
}

nlohmann::json Number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

double FromNumber(const nlohmann::json& json) {
  return json.is_null() ? std::nan("") : json.get<double>();
}

}  // namespace

std::optional<bool> BenchRow::met() const {
  switch (bar.kind) {
    case Bar::Kind::kAtLeast:
      return std::isfinite(ratio) && ratio >= bar.limit;
    case Bar::Kind::kAtMost:
      return std::isfinite(ratio) && ratio <= bar.limit;
    case Bar::Kind::kNone:
      break;
  }
  return std::nullopt;
}

BenchRow SpeedupRow(std::string name, double ours, std::string against, double theirs,
                    std::string unit, Bar bar) {
  return {
      std::move(name), ours, std::move(against), theirs, std::move(unit), theirs / ours, bar, {}};
}

BenchRow RatioRow(std::string name, double ours, std::string against, double theirs,
                  std::string unit, Bar bar) {
  return {
      std::move(name), ours, std::move(against), theirs, std::move(unit), ours / theirs, bar, {}};
}

std::string ToMarkdown(const BenchTable& table) {
  std::vector<Line> lines{{"what", "against", "ours", "theirs", "ratio", "bar", ""}};
  for (const BenchRow& row : table.rows) lines.push_back(ToLine(row));
  std::array<std::size_t, kColumns> widths{};
  for (const Line& line : lines) {
    for (int c = 0; c < kColumns; ++c)
      widths[c] = std::max({widths[c], line[c].size(), std::size_t{3}});
  }
  std::string text = fmt::format("### {}\n\n", table.title);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (int c = 0; c < kColumns; ++c) {
      text += c < kFirstNumber ? fmt::format("| {:<{}} ", lines[i][c], widths[c])
                               : fmt::format("| {:>{}} ", lines[i][c], widths[c]);
    }
    text += "|\n";
    if (i > 0) continue;
    for (int c = 0; c < kColumns; ++c) {
      text += c < kFirstNumber ? fmt::format("|{:-<{}}", "", widths[c] + 2)
                               : fmt::format("|{:->{}}", ":", widths[c] + 2);
    }
    text += "|\n";
  }
  text += '\n';
  for (const std::string& note : table.notes) text += fmt::format("- {}\n", note);
  for (const BenchRow& row : table.rows) {
    if (!row.note.empty()) text += fmt::format("- {}: {}\n", row.name, row.note);
  }
  return text;
}

nlohmann::json ToJson(const BenchTable& table) {
  nlohmann::json rows = nlohmann::json::array();
  for (const BenchRow& row : table.rows) {
    nlohmann::json bar;
    if (row.bar.kind == Bar::Kind::kAtLeast) bar = {{"at_least", row.bar.limit}};
    if (row.bar.kind == Bar::Kind::kAtMost) bar = {{"at_most", row.bar.limit}};
    const std::optional<bool> met = row.met();
    rows.push_back({{"name", row.name},
                    {"ours", Number(row.ours)},
                    {"unit", row.unit},
                    {"against", row.against},
                    {"theirs", Number(row.theirs)},
                    {"ratio", Number(row.ratio)},
                    {"bar", bar},
                    {"met", met ? nlohmann::json(*met) : nlohmann::json(nullptr)},
                    {"note", row.note}});
  }
  return {{"title", table.title}, {"notes", table.notes}, {"rows", rows}};
}

absl::StatusOr<BenchTable> FromJson(const nlohmann::json& json) {
  try {
    BenchTable table;
    json.at("title").get_to(table.title);
    json.at("notes").get_to(table.notes);
    for (const nlohmann::json& row : json.at("rows")) {
      BenchRow& read = table.rows.emplace_back();
      row.at("name").get_to(read.name);
      read.ours = FromNumber(row.at("ours"));
      row.at("unit").get_to(read.unit);
      row.at("against").get_to(read.against);
      read.theirs = FromNumber(row.at("theirs"));
      read.ratio = FromNumber(row.at("ratio"));
      row.at("note").get_to(read.note);
      const nlohmann::json& bar = row.at("bar");
      if (bar.is_null()) continue;
      read.bar = bar.contains("at_least") ? AtLeast(bar.at("at_least").get<double>())
                                          : AtMost(bar.at("at_most").get<double>());
    }
    return table;
  } catch (const nlohmann::json::exception& error) {
    return core::InvalidArgument("expected a benchmark table: {}", error.what());
  }
}

int Finish(const BenchTable& table, const std::string& json_file) {
  fmt::print("{}\n", ToMarkdown(table));
  if (json_file.empty()) return 0;
  std::ofstream file(json_file);
  file << ToJson(table).dump(2) << '\n';
  if (file.flush()) return 0;
  fmt::print(stderr, "{}: cannot write the file\n", json_file);
  return 1;
}

}  // namespace motiondb::tests
