// Output of the command line as text, tables and JSON. All output goes through these functions,
// which replace control characters in strings of servers and files (text/display_text.h).
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

// Prints text of several lines, with line ends, to standard output.
void PrintText(std::string_view text);

// Prints one line, given without line end, to standard output. Line ends in it are replaced.
void PrintLineText(std::string_view line);
template <typename... Args>
void PrintLine(fmt::format_string<Args...> format, Args&&... args) {
  PrintLineText(fmt::format(format, std::forward<Args>(args)...));
}

// Prints "motiondb: ERROR" to standard error. Removes secrets of tokens.
void PrintError(std::string_view error);

// Returns "1 clip", "2 clips": adds an s to `noun`.
std::string CountText(std::int64_t count, const char* noun);

enum class Align { kLeft, kRight };

class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };

  // Without titles there is no title line.
  explicit Table(std::vector<Column> columns);

  // One cell for each column.
  void AddRow(std::vector<std::string> cells);

  // Returns lines with line ends. Columns are two spaces apart; lines have no trailing spaces.
  std::string ToString() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

// Returns the number of characters of UTF-8 text.
size_t DisplayWidth(const std::string& text);

// Appends spaces to `text` up to `width` characters.
std::string PadRight(const std::string& text, size_t width);

// Returns a message as one line of JSON without line end: proto field names, default values
// included.
std::string JsonLine(const google::protobuf::Message& message);

// Returns a message as indented JSON.
std::string IndentedJson(const google::protobuf::Message& message);

// Returns a quoted and escaped JSON string.
std::string JsonString(const std::string& text);

// Prints JsonLine to standard output.
void PrintJson(const google::protobuf::Message& message);

}  // namespace motiondb::client
