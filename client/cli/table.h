// Text in aligned columns, for a person.
#pragma once

#include <string>
#include <vector>

namespace motiondb::client {

enum class Align { kLeft, kRight };

class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };

  // Without a title in any column no title line is printed.
  explicit Table(std::vector<Column> columns);

  // One cell for each column.
  void AddRow(std::vector<std::string> cells);

  // Lines, each ended by '\n', columns two spaces apart, no spaces at the end of a line.
  std::string ToString() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

// Characters of UTF-8 text, as a terminal shows them.
size_t DisplayWidth(const std::string& text);

// `text` followed by spaces up to `width` characters.
std::string PadRight(const std::string& text, size_t width);

}  // namespace motiondb::client
