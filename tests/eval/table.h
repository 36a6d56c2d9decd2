// What a protocol found out, for people (Markdown) and for programs (JSON).
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
  std::vector<double> figures;  // one a column; NaN where there is none
  std::string chosen;           // how the method's parameters were chosen
};

struct Table {
  std::string title;
  std::vector<Column> columns;
  std::vector<Row> rows;
  std::vector<std::string> notes;
};

// A Markdown table, columns aligned; below it the notes, and for each row how its parameters were
// chosen.
std::string ToMarkdown(const Table& table);

// {"title", "notes", "rows": [{"method", "chosen", "figures": {column: number or null}}]}.
nlohmann::json ToJson(const Table& table);

}  // namespace motiondb::tests
