// The result of a protocol, as Markdown and JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace motiondb::tests {

struct Column {
  std::string name;
  int decimals = 1;
};

struct Row {
  std::string method;
  std::vector<double> figures;  // one per column; NaN if there is none
  std::string chosen;           // how the method's parameters were chosen
};

struct Table {
  std::string title;
  std::vector<Column> columns;
  std::vector<Row> rows;
  std::vector<std::string> notes;
};

// Returns a Markdown table with aligned columns, then the notes and how each row's parameters were
// chosen.
std::string ToMarkdown(const Table& table);

// Returns {"title", "notes", "rows": [{"method", "chosen", "figures": {column: number or null}}]}.
nlohmann::json ToJson(const Table& table);

}  // namespace motiondb::tests
