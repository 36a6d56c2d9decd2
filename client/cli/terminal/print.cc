#include "client/cli/terminal/print.h"

#include <fmt/format.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <motiondb/client.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>

#include "absl/strings/escaping.h"
#include "client/output_file.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

// The file of --output; null: standard output.
struct OutputState {
  std::optional<OutputFile> file;
  absl::Status status = absl::OkStatus();
  bool has_content = false;
};

OutputState& Output() {
  static OutputState state;
  return state;
}

void Write(std::string_view text) {
  OutputState& output = Output();
  output.has_content = output.has_content || !text.empty();
  if (output.file) {
    output.status.Update(output.file->Append(text));
  } else {
    std::fwrite(text.data(), 1, text.size(), stdout);
  }
}

}  // namespace

absl::Status OpenOutputFile(const std::filesystem::path& path) {
  auto file = OutputFile::CreateReplacing(path);
  if (!file.ok()) return file.status();
  Output().file = *std::move(file);
  return absl::OkStatus();
}

absl::Status EndOutput() {
  OutputState& output = Output();
  if (!output.file) {
    const bool is_written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
    return is_written ? absl::OkStatus()
                      : absl::DataLossError("standard output: cannot be written");
  }
  if (output.status.ok() && output.has_content) {
    output.status = output.file->Commit(/*replace=*/true);
  }
  return output.status;
}

bool OutputFailed() { return !Output().status.ok() || std::ferror(stdout) != 0; }

bool IsOnTerminal() { return !Output().file && isatty(STDOUT_FILENO) == 1; }

TerminalSize OutputSize() { return Output().file ? TerminalSize() : SizeOfTerminal(STDOUT_FILENO); }

void FlushOutput() {
  if (!Output().file) std::fflush(stdout);
}

void ClearOutputLine() {
  if (IsOnTerminal()) Write("\r\033[K");
}

void ClearOutputScreen() {
  if (IsOnTerminal()) Write("\033[H\033[J");
}

void PrintText(std::string_view text) {
  Write(WithStyles(text, !Output().file && HasColours(STDOUT_FILENO)));
}

void PrintTabSeparated(std::string_view text) {
  for (std::size_t end = text.find('\t'); end != std::string_view::npos; end = text.find('\t')) {
    PrintText(text.substr(0, end));
    Write("\t");
    text.remove_prefix(end + 1);
  }
  PrintText(text);
}

void PrintLineText(std::string_view line) { Write(text::DisplayText(line) + '\n'); }

void PrintError(std::string_view error) {
  fmt::print(stderr, "{} {}\n",
             WithStyles(Styled(Style::kError, "motiondb:"), HasColours(STDERR_FILENO)),
             text::SafeText(error));
}

std::string Table::ToString() const { return ToString(OutputSize().columns); }

void PrintTable(const Table& table, bool as_csv, std::string_view if_empty) {
  if (as_csv) {
    PrintText(table.ToCsv());
  } else if (table.empty()) {
    PrintLineText(if_empty);
  } else {
    PrintText(table.ToString());
  }
}

std::string WithSummary(const std::string& body, const std::string& summary) {
  const std::string text = body + summary;
  const auto lines = static_cast<std::size_t>(std::ranges::count(text, '\n'));
  // The prompt needs a line.
  return lines < OutputSize().rows ? text : summary + body;
}

std::string CountText(std::int64_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

namespace {

// Fields of packed float32: the names of the bytes fields of motiondb.v1 that hold numbers.
constexpr std::string_view kPackedFields[] = {"angles",
                                              "joint_angles",
                                              "joint_positions",
                                              "joint_rotations",
                                              "marker_deviations",
                                              "marker_positions",
                                              "marker_velocities",
                                              "mean",
                                              "positions",
                                              "scales",
                                              "states",
                                              "variance"};

std::string NumbersText(const std::string& bytes) {
  std::string text;
  for (const float value : UnpackFloats(bytes)) {
    if (!text.empty()) text += ',';
    if (std::isfinite(value)) {
      fmt::format_to(std::back_inserter(text), "{}", value);
    } else {  // as the JSON form of a float field
      text += std::isnan(value) ? "\"NaN\"" : value > 0 ? "\"Infinity\"" : "\"-Infinity\"";
    }
  }
  return "[" + text + "]";
}

// Prints packed fields as arrays of numbers, and outcomes of plans as the words of the command line
// (EXACT), in one pass. A quotation mark within a JSON string is escaped, so that only a key ends
// with `":` after its plain name.
std::string Readable(const std::string& json) {
  constexpr std::string_view kOutcome = "PLAN_OUTCOME_";
  std::string text;
  size_t copied = 0;
  for (size_t at = json.find("\":"); at != std::string::npos; at = json.find("\":", at + 2)) {
    const size_t key_begin = json.rfind('"', at - 1) + 1;
    const std::string_view key = std::string_view(json).substr(key_begin, at - key_begin);
    const size_t begin = json.find_first_not_of(' ', at + 2);
    if (begin == std::string::npos || json[begin] != '"') continue;
    if (key == "outcome" && json.compare(begin + 1, kOutcome.size(), kOutcome) == 0) {
      text.append(json, copied, begin + 1 - copied);
      copied = begin + 1 + kOutcome.size();
    } else if (std::ranges::find(kPackedFields, key) != std::end(kPackedFields)) {
      const size_t end = json.find('"', begin + 1);
      std::string bytes;
      if (!absl::Base64Unescape(json.substr(begin + 1, end - begin - 1), &bytes)) continue;
      text.append(json, copied, begin - copied);
      text += NumbersText(bytes);
      copied = end + 1;
    }
  }
  return text.append(json, copied);
}

std::string JsonText(const google::protobuf::Message& message, bool indented) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  options.add_whitespace = indented;
  std::string json;
  // Fails only for an Any of an unknown type; callers remove these.
  (void)google::protobuf::util::MessageToJsonString(message, &json, options);
  return text::EscapedJson(Readable(json));
}

}  // namespace

std::string JsonLine(const google::protobuf::Message& message) { return JsonText(message, false); }

std::string IndentedJson(const google::protobuf::Message& message) {
  return JsonText(message, true);
}

std::string JsonString(const std::string& text) {
  google::protobuf::Value value;
  value.set_string_value(text);
  return JsonText(value, false);
}

void PrintJson(const google::protobuf::Message& message) { PrintJson(message, ""); }

void PrintJson(const google::protobuf::Message& message, const std::string& file) {
  std::string line = JsonLine(message);
  if (!file.empty()) {
    const bool has_fields = line != "{}";
    line.replace(0, 1, "{\"file\":" + JsonString(file) + (has_fields ? "," : ""));
  }
  Write(line + '\n');
  FlushOutput();
}

}  // namespace motiondb::client
