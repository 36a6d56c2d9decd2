#include "client/cli/terminal/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>
#include <utility>

#include "text/display_text.h"

namespace motiondb::client {
namespace {

constexpr std::size_t kMinShortened = 9;
constexpr std::size_t kMinWrapped = 8;

std::string Padded(const std::string& text, std::size_t width, Align align, Style style) {
  const std::string shown = Shortened(text, width);
  const std::string space(width - DisplayWidth(shown), ' ');
  const std::string styled = Styled(style, shown);
  return align == Align::kLeft ? styled + space : space + styled;
}

void EndLine(std::string& line) {
  line.erase(line.find_last_not_of(' ') + 1);
  line += '\n';
}

std::size_t TotalWidth(const std::vector<std::size_t>& widths) {
  return std::accumulate(widths.begin(), widths.end(),
                         2 * (std::max<std::size_t>(widths.size(), 1) - 1));
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

// Returns the first characters of the text.
std::string FirstCharacters(const std::string& text, std::size_t count) {
  std::size_t end = 0;
  for (std::size_t seen = 0; end < text.size(); ++end) {
    if (!text::IsContinuationByte(text[end]) && seen++ == count) break;
  }
  return text.substr(0, end);
}

}  // namespace

Cell::Cell(const std::string& text, Style style) : text_(text::DisplayText(text)), style_(style) {}

Cell::Cell(double number, int decimals) {
  if (std::isnan(number)) return;
  text_ = fmt::format("{:.{}f}", number, decimals);
  exact_ = fmt::format("{}", number);
}

std::size_t DisplayWidth(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return !text::IsContinuationByte(c); }));
}

std::string Shortened(const std::string& text, std::size_t width) {
  if (DisplayWidth(text) <= width) return text;
  constexpr std::string_view kMore = "...";
  if (width <= kMore.size()) return FirstCharacters(text, width);
  return FirstCharacters(text, width - kMore.size()).append(kMore);
}

std::string Wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  width = std::max(width, indent + 1);
  std::string lines;
  std::size_t used = indent;  // characters of the last line
  const auto begin_line = [&] {
    lines += '\n' + std::string(indent, ' ');
    used = indent;
  };
  for (std::size_t begin = text.find_first_not_of(' '); begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    std::string word = text.substr(begin, end - begin);
    if (used > indent && used + 1 + DisplayWidth(word) > width) begin_line();
    if (used > indent) {
      lines += ' ';
      ++used;
    }
    while (used + DisplayWidth(word) > width) {
      const std::string part = FirstCharacters(word, width - used);
      lines += part;
      word.erase(0, part.size());
      begin_line();
    }
    lines += word;
    used += DisplayWidth(word);
    begin = std::min(text.find_first_not_of(' ', end), text.size());
  }
  return lines;
}

Table::Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

void Table::AddRow(std::vector<Cell> cells) {
  cells.resize(columns_.size());
  rows_.push_back(std::move(cells));
}

Table Table::WithoutEmptyColumns() const {
  Table kept({});
  kept.rows_.resize(rows_.size());
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const bool is_empty =
        !rows_.empty() && !columns_[i].title.empty() &&
        std::ranges::all_of(rows_, [&](const auto& row) { return row[i].text().empty(); });
    if (is_empty) continue;
    kept.columns_.push_back(columns_[i]);
    for (std::size_t r = 0; r < rows_.size(); ++r) kept.rows_[r].push_back(rows_[r][i]);
  }
  return kept;
}

std::vector<std::size_t> Table::Widths() const {
  std::vector<std::size_t> widths;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    widths.push_back(DisplayWidth(columns_[i].title));
    for (const auto& row : rows_) widths[i] = std::max(widths[i], DisplayWidth(row[i].text()));
  }
  return widths;
}

bool Table::HasTitles() const {
  return std::ranges::any_of(columns_, [](const Column& column) { return !column.title.empty(); });
}

std::string Table::Lines(const std::vector<std::size_t>& widths) const {
  std::string text;
  const auto add_line = [&](const auto& cell_of) {
    std::string line;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const auto [content, style] = cell_of(i);
      line += (i > 0 ? "  " : "") + Padded(content, widths[i], columns_[i].align, style);
    }
    EndLine(line);
    text += line;
  };
  if (HasTitles()) {
    add_line([&](std::size_t i) { return std::pair(columns_[i].title, Style::kHeading); });
  }
  for (const auto& row : rows_) {
    add_line([&](std::size_t i) { return std::pair(row[i].text(), row[i].style()); });
  }
  return text;
}

std::string Table::Records(std::size_t max_width) const {
  const bool has_titles = HasTitles();
  std::size_t name_width = 0;  // of the titles; without titles, of the first column
  for (const Column& column : columns_) {
    name_width = std::max(name_width, DisplayWidth(column.title));
  }
  if (!has_titles && !columns_.empty()) name_width = Widths().front();
  name_width = std::min(name_width, max_width / 2);
  std::string text;
  const auto add_line = [&](const std::string& name, Style name_style, const Cell& cell) {
    const std::size_t indent = name_width + 2;
    std::string line = Padded(name, name_width, Align::kLeft, name_style) + "  ";
    const std::string content =
        Wrapped(cell.text(), std::max(max_width, indent + kMinWrapped), indent);
    line += content.find('\n') == std::string::npos ? Styled(cell.style(), content) : content;
    EndLine(line);
    text += line;
  };
  for (const auto& row : rows_) {
    if (has_titles && !text.empty()) text += '\n';
    for (std::size_t i = has_titles ? 0 : 1; i < columns_.size(); ++i) {
      if (has_titles && row[i].text().empty()) continue;
      const std::string name = has_titles ? columns_[i].title : i == 1 ? row[0].text() : "";
      add_line(name, has_titles ? Style::kHeading : row[0].style(), row[i]);
    }
  }
  return text;
}

std::string Table::ToString(std::size_t max_width) const {
  const Table shown = WithoutEmptyColumns();
  std::vector<std::size_t> widths = shown.Widths();
  // One character at a time, so that columns of similar widths are shortened alike.
  for (std::size_t excess = TotalWidth(widths); excess > max_width; --excess) {
    std::size_t widest = 0;  // of the columns that can be shortened; 0: there is none
    for (std::size_t i = 1; i < widths.size() && shown.HasTitles(); ++i) {
      const Column& column = shown.columns_[i];
      const std::size_t least = std::max(kMinShortened, DisplayWidth(column.title));
      const bool can_shrink = column.align == Align::kLeft && widths[i] > least;
      if (can_shrink && (widest == 0 || widths[i] > widths[widest])) widest = i;
    }
    if (widest == 0) return shown.Records(max_width);
    --widths[widest];
  }
  return shown.Lines(widths);
}

std::string Table::ToCsv() const {
  std::string text;
  for (const Column& column : columns_) {
    text += (text.empty() ? "" : ",") + CsvField(column.title);
  }
  return text + '\n' + CsvRows();
}

std::string Table::CsvRows() const {
  std::string text;
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      text += (i > 0 ? "," : "") + CsvField(row[i].exact());
    }
    text += '\n';
  }
  return text;
}

Table Table::WithFirstColumn(const std::string& title, const std::string& text) const {
  Table wider = *this;
  wider.columns_.insert(wider.columns_.begin(), {title});
  for (auto& row : wider.rows_) row.insert(row.begin(), Cell(text));
  return wider;
}

}  // namespace motiondb::client
