// Output of the command line: standard output, or the file of --output. All output goes through
// these functions, which replace control characters in strings of servers and files
// (text/display_text.h).
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "client/cli/terminal/table.h"
#include "client/cli/terminal/terminal.h"

namespace google::protobuf {
class Message;
}

namespace motiondb::client {

// Sends what is printed from now on to a file instead of standard output. The file appears with
// EndOutput. UNKNOWN: it cannot be written.
absl::Status OpenOutputFile(const std::filesystem::path& file);

// Completes the output: standard output or the file. DATA_LOSS or UNKNOWN: it cannot be written.
// Without any output, no file appears.
absl::Status EndOutput();

// Whether the output is incomplete because of an error, which EndOutput returns.
bool OutputFailed();

// Size of the output if it is a terminal.
TerminalSize OutputSize();

// Whether the output is a terminal, and not the file of --output.
bool IsOnTerminal();

// Prints text of several lines, with line ends.
void PrintText(std::string_view text);

// As PrintText, but keeps tabs.
void PrintTabSeparated(std::string_view text);

// Prints one line, given without line end. Line ends in it are replaced.
void PrintLineText(std::string_view line);
template <typename... Args>
void PrintLine(fmt::format_string<Args...> format, Args&&... args) {
  PrintLineText(fmt::format(format, std::forward<Args>(args)...));
}

// Prints a table as CSV, or fitted to the terminal; `if_empty`, a line, instead of a table without
// rows.
void PrintTable(const Table& table, bool as_csv, std::string_view if_empty);

// Returns the body, then the summary. If they do not fit on the screen, the summary is first.
std::string WithSummary(const std::string& body, const std::string& summary);

// Passes the output on to the reader of a pipe immediately.
void FlushOutput();

// On a terminal, moves to the beginning of the line or of the screen, and clears it.
void ClearOutputLine();
void ClearOutputScreen();

// Prints "motiondb: ERROR" to standard error. Removes secrets of tokens.
void PrintError(std::string_view error);

// Returns "1 clip", "2 clips": adds an s to `noun`.
std::string CountText(std::int64_t count, const char* noun);

// Returns a message as one line of JSON without line end: proto field names, default values
// included.
std::string JsonLine(const google::protobuf::Message& message);

// Returns a message as indented JSON.
std::string IndentedJson(const google::protobuf::Message& message);

// Returns a quoted and escaped JSON string.
std::string JsonString(const std::string& text);

// Prints JsonLine.
void PrintJson(const google::protobuf::Message& message);

// As PrintJson, with the field "file" before the fields of the message; without it if `file` is
// empty.
void PrintJson(const google::protobuf::Message& message, const std::string& file);

}  // namespace motiondb::client
