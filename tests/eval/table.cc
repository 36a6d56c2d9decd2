#include "tests/eval/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace motiondb::tests {
namespace {

std::string Figure(double value, int decimals) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, decimals);
}

}  // namespace

std::string ToMarkdown(const Table& table) {
  std::vector<std::vector<std::string>> lines{{""}};
  for (const Column& column : table.columns) lines[0].push_back(column.name);
  for (const Row& row : table.rows) {
    std::vector<std::string>& line = lines.emplace_back(1, row.method);
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      line.push_back(Figure(row.figures[c], table.columns[c].decimals));
    }
  }
  std::vector<std::size_t> widths(lines[0].size(), 3);
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  std::string text = fmt::format("#### {}\n\n", table.title);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t c = 0; c < lines[i].size(); ++c) {
      text += c == 0 ? fmt::format("| {:<{}} |", lines[i][c], widths[c])
                     : fmt::format(" {:>{}} |", lines[i][c], widths[c]);
    }
    text += '\n';
    if (i > 0) continue;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      text += c == 0 ? fmt::format("|{:-<{}}|", "", widths[c] + 2)
                     : fmt::format("{:->{}}|", ":", widths[c] + 2);
    }
    text += '\n';
  }
  text += '\n';
  for (const std::string& note : table.notes) text += fmt::format("{}\n", note);
  for (const Row& row : table.rows) {
    if (!row.chosen.empty()) text += fmt::format("- {}: {}\n", row.method, row.chosen);
  }
  return text;
}

nlohmann::json ToJson(const Table& table) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Row& row : table.rows) {
    nlohmann::json figures = nlohmann::json::object();
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const double value = row.figures[c];
      figures[table.columns[c].name] =
          std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
    }
    rows.push_back({{"method", row.method}, {"chosen", row.chosen}, {"figures", figures}});
  }
  return {{"title", table.title}, {"notes", table.notes}, {"rows", rows}};
}

}  // namespace motiondb::tests
