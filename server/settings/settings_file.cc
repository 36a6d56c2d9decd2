#include "server/settings/settings_file.h"

#include <fmt/format.h>

#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kLargestFile = std::size_t{1} << 20;
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // some editors begin UTF-8 with it

// One line, read from the left.
class LineReader {
 public:
  explicit LineReader(const std::string& line) : line_(line) {}

  void SkipBlanks() {
    while (at_ < line_.size() && std::isspace(static_cast<unsigned char>(line_[at_])) != 0) ++at_;
  }
  bool AtEnd() {
    SkipBlanks();
    return at_ == line_.size() || line_[at_] == '#';
  }
  bool Take(char expected) {
    SkipBlanks();
    if (at_ == line_.size() || line_[at_] != expected) return false;
    ++at_;
    return true;
  }
  // Up to a blank or one of `ends`.
  std::string Word(const char* ends) {
    SkipBlanks();
    std::size_t end = line_.find_first_of(std::string(ends) + " \t\r#", at_);
    if (end == std::string::npos) end = line_.size();
    const std::string word = line_.substr(at_, end - at_);
    at_ = end;
    return word;
  }
  absl::StatusOr<std::string> Value() {
    if (Take('"')) return Quoted();
    if (Take('\'')) return Literal();
    std::string word = Word(",[]=\"'");
    if (word.empty()) return core::InvalidArgument("expected a value");
    return word;
  }

 private:
  absl::StatusOr<std::string> Quoted() {
    std::string value;
    while (at_ < line_.size()) {
      const char c = line_[at_++];
      if (c == '"') return value;
      if (c != '\\') {
        value += c;
        continue;
      }
      const char escape = at_ < line_.size() ? line_[at_++] : '\0';
      switch (escape) {
        case '"':
        case '\\':
          value += escape;
          break;
        case 'n':
          value += '\n';
          break;
        case 't':
          value += '\t';
          break;
        default:
          return core::InvalidArgument("expected \\\", \\\\, \\n or \\t after a backslash");
      }
    }
    return core::InvalidArgument("expected a closing \"");
  }
  absl::StatusOr<std::string> Literal() {
    const std::size_t end = line_.find('\'', at_);
    if (end == std::string::npos) return core::InvalidArgument("expected a closing '");
    const std::string value = line_.substr(at_, end - at_);
    at_ = end + 1;
    return value;
  }

  const std::string& line_;
  std::size_t at_ = 0;
};

absl::StatusOr<std::vector<std::string>> ParseArray(LineReader& reader) {
  std::vector<std::string> values;
  while (!reader.Take(']')) {
    if (!values.empty() && !reader.Take(',')) {
      return core::InvalidArgument("expected , or ] in an array, which is on one line");
    }
    if (!values.empty() && reader.Take(']')) break;  // after a last comma
    MOTIONDB_ASSIGN_OR_RETURN(values.emplace_back(), reader.Value());
  }
  return values;
}

absl::StatusOr<std::optional<FileSetting>> ParseLine(const std::string& line) {
  LineReader reader(line);
  if (reader.AtEnd()) return std::nullopt;
  if (reader.Take('[')) return core::InvalidArgument("expected `key = value`; there are no tables");
  FileSetting setting;
  setting.key = reader.Word("=");
  if (setting.key.empty() || !reader.Take('=')) {
    return core::InvalidArgument("expected `key = value`");
  }
  if (reader.Take('[')) {
    MOTIONDB_ASSIGN_OR_RETURN(setting.values, ParseArray(reader));
  } else {
    MOTIONDB_ASSIGN_OR_RETURN(setting.values.emplace_back(), reader.Value());
  }
  if (!reader.AtEnd()) {
    return core::InvalidArgument("{}: expected one value; quote one that has spaces", setting.key);
  }
  return setting;
}

bool IsNumberOrTruth(const std::string& value) {
  if (value == "true" || value == "false") return true;
  double number = 0;
  const char* const end = value.data() + value.size();
  const auto [rest, error] = std::from_chars(value.data(), end, number);
  return error == std::errc() && rest == end &&
         std::isdigit(static_cast<unsigned char>(value.back())) != 0;
}

std::string Quote(const std::string& value) {
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n') {
      quoted += "\\n";
    } else if (c == '\t') {
      quoted += "\\t";
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace

std::vector<FileSetting> ParseSettings(const std::string& name, const std::string& text,
                                       std::vector<absl::Status>& problems) {
  std::vector<FileSetting> settings;
  std::map<std::string, int> line_of_key;
  std::istringstream lines(text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size())
                                                            : text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    absl::StatusOr<std::optional<FileSetting>> setting = ParseLine(line);
    if (!setting.ok()) {
      problems.push_back(core::InvalidArgument("{}:{}: {}", name, number,
                                               std::string(setting.status().message())));
      continue;
    }
    if (!setting->has_value()) continue;
    (*setting)->line = number;
    const auto [earlier, is_new] = line_of_key.emplace((*setting)->key, number);
    if (!is_new) {
      problems.push_back(core::InvalidArgument("{}:{}: {}: set before, in line {}", name, number,
                                               (*setting)->key, earlier->second));
      continue;
    }
    settings.push_back(**std::move(setting));
  }
  return settings;
}

absl::StatusOr<std::string> ReadSettingsFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file) {
    text.resize(kLargestFile + 1);
    errno = 0;
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
  }
  if (!file.is_open() || file.bad()) {
    return absl::ErrnoToStatus(errno, fmt::format("{}: cannot be read", path));
  }
  if (text.size() > kLargestFile) {
    return core::InvalidArgument("{}: is larger than 1 MiB, which no configuration is", path);
  }
  return text;
}

std::string FormatValues(const std::vector<std::string>& values, bool is_array) {
  const auto format = [](const std::string& value) {
    return IsNumberOrTruth(value) ? value : Quote(value);
  };
  if (!is_array) return values.empty() ? "\"\"" : format(values.front());
  std::string array;
  for (const std::string& value : values) array += (array.empty() ? "" : ", ") + format(value);
  return "[" + array + "]";
}

}  // namespace motiondb::server
