#include "client/cli/print.h"

#include <fmt/format.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <motiondb/client.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <utility>

#include "absl/strings/escaping.h"
#include "text/display_text.h"

namespace motiondb::client {

void PrintText(std::string_view text) { fmt::print("{}", text::DisplayLines(text)); }

void PrintLineText(std::string_view line) { fmt::print("{}\n", text::DisplayText(line)); }

void PrintError(std::string_view error) {
  fmt::print(stderr, "motiondb: {}\n", text::SafeText(error));
}

std::string CountText(std::int64_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

namespace {

std::string Line(const std::vector<Table::Column>& columns, const std::vector<size_t>& widths,
                 const std::vector<std::string>& cells) {
  std::string line;
  for (size_t i = 0; i < columns.size(); ++i) {
    if (i > 0) line += "  ";
    const std::string space(widths[i] - DisplayWidth(cells[i]), ' ');
    line += columns[i].align == Align::kLeft ? cells[i] + space : space + cells[i];
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

}  // namespace

size_t DisplayWidth(const std::string& text) {
  return static_cast<size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return !text::IsContinuationByte(c); }));
}

std::string PadRight(const std::string& text, size_t width) {
  const size_t shown = DisplayWidth(text);
  return shown < width ? text + std::string(width - shown, ' ') : text;
}

Table::Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

void Table::AddRow(std::vector<std::string> cells) {
  for (std::string& cell : cells) cell = text::DisplayText(cell);
  cells.resize(columns_.size());
  rows_.push_back(std::move(cells));
}

std::string Table::ToString() const {
  std::vector<std::string> titles;
  std::vector<size_t> widths;
  for (const Column& column : columns_) {
    titles.push_back(column.title);
    widths.push_back(DisplayWidth(column.title));
  }
  const bool titled = std::any_of(widths.begin(), widths.end(), [](size_t w) { return w > 0; });
  for (const auto& row : rows_) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], DisplayWidth(row[i]));
  }
  std::string text = titled ? Line(columns_, widths, titles) : "";
  for (const auto& row : rows_) text += Line(columns_, widths, row);
  return text;
}

namespace {

// Fields of packed float32: the names of the bytes fields of motiondb.v1 that hold numbers.
constexpr std::string_view kPackedFields[] = {"angles", "joint_angles",     "marker_deviations",
                                              "mean",   "marker_positions", "positions",
                                              "scales", "states",           "variance"};

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

void PrintJson(const google::protobuf::Message& message) {
  fmt::print("{}\n", JsonLine(message));
  // Flushes, so that the reader of a pipe gets each answer immediately.
  std::fflush(stdout);
}

}  // namespace motiondb::client
