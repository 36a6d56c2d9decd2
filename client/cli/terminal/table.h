// Tables: fitted to the terminal, or as CSV.
#pragma once

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "client/cli/terminal/terminal.h"

namespace motiondb::client {

enum class Align { kLeft, kRight };

// A text or a number.
class Cell {
 public:
  Cell() = default;
  // Control characters are replaced.
  Cell(const std::string& text,
       Style style = Style::kPlain);                   // NOLINT(google-explicit-constructor)
  Cell(const char* text) : Cell(std::string(text)) {}  // NOLINT(google-explicit-constructor)
  template <typename Integer>
  requires std::is_integral_v<Integer> Cell(Integer number)  // NOLINT(google-explicit-constructor)
      : Cell(std::to_string(number)) {}
  // Shown with `decimals` digits after the point; CSV has all digits. Empty if it is NaN.
  Cell(double number, int decimals);

  const std::string& text() const { return text_; }
  const std::string& exact() const { return exact_.empty() ? text_ : exact_; }
  Style style() const { return style_; }

 private:
  std::string text_;
  std::string exact_;  // if different
  Style style_ = Style::kPlain;
};

class Table {
 public:
  // A number has its unit in the title: "LENGTH (s)".
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };

  // Without titles there is no title line.
  explicit Table(std::vector<Column> columns);

  // At most one cell for each column.
  void AddRow(std::vector<Cell> cells);

  bool empty() const { return rows_.empty(); }

  // Returns lines with line ends, of at most `max_width` characters. Columns are two spaces apart;
  // lines have no trailing spaces. A column with a title and without any content is left out. If
  // the table is too wide, left-aligned columns after the first one are shortened to 9 characters
  // or more. If this does not suffice, or there are no titles, each cell is a line "TITLE  content"
  // (without titles: "FIRST CELL  content"), and a longer content continues below.
  std::string ToString(std::size_t max_width) const;
  std::string ToString() const;  // for the terminal (print.h)

  // Returns all rows and columns as CSV (RFC 4180, with line feeds), after a line with the titles.
  std::string ToCsv() const;
  std::string CsvRows() const;  // without the titles

  // Returns a copy with one more column, which has the same text in all rows.
  Table WithFirstColumn(const std::string& title, const std::string& text) const;

 private:
  bool HasTitles() const;
  Table WithoutEmptyColumns() const;
  std::vector<std::size_t> Widths() const;
  std::string Lines(const std::vector<std::size_t>& widths) const;
  std::string Records(std::size_t max_width) const;

  std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
};

// Returns the number of characters of UTF-8 text.
std::size_t DisplayWidth(const std::string& text);

// Returns the text, or its beginning and "…", in at most `width` characters.
std::string Shortened(const std::string& text, std::size_t width);

// Returns the words in lines of at most `width` characters, joined by line feeds. All lines, also
// the first one, which the caller has begun, begin at column `indent`. A word that is longer is
// cut.
std::string Wrapped(const std::string& text, std::size_t width, std::size_t indent);

}  // namespace motiondb::client
