// What the command line prints goes through here, text and JSON: no string of a
// server or a file reaches a terminal with display controls in it (client/display_text.h). Counts
// in words, and text in aligned columns.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace google::protobuf {
class Message;
}

namespace motiondb::client {

// To standard output: text of several lines, each with its line end.
void PrintText(std::string_view text);

// To standard output: one line, without its line end, which a string in it does not end either.
void PrintLineText(std::string_view line);
template <typename... Args>
void PrintLine(fmt::format_string<Args...> format, Args&&... args) {
  PrintLineText(fmt::format(format, std::forward<Args>(args)...));
}

// To standard error: "motiondb: ..." and a line end. The secrets of tokens are left out.
void PrintError(std::string_view error);

// "1 clip", "2 clips"; `noun` takes an s.
std::string CountText(std::int64_t count, const char* noun);

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

// Answers as JSON: the proto's field names, zeros included, one object a line.

// One line, without its line end.
std::string JsonLine(const google::protobuf::Message& message);

// The same, indented.
std::string IndentedJson(const google::protobuf::Message& message);

// A string as JSON, quoted and escaped.
std::string JsonString(const std::string& text);

// Prints one line to standard output.
void PrintJson(const google::protobuf::Message& message);

}  // namespace motiondb::client
