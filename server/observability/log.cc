#include "server/observability/log.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdio>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "text/display_text.h"

namespace motiondb::server {

namespace {

thread_local const LogFields* current = nullptr;

}  // namespace

LogFields::LogFields(std::initializer_list<LogField> fields) : fields_(fields), outer_(current) {
  current = this;
}

LogFields::~LogFields() { current = outer_; }

const LogFields* LogFields::Current() { return current; }

void StartLog(LogFormat format, const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("motiondbd"));
  spdlog::set_level(spdlog::level::from_str(level));
  spdlog::set_formatter(MakeLogFormatter(format));
}

void PrintAlways(LogFormat format, const std::string& message) {
  if (format == LogFormat::kText) {
    std::fputs(fmt::format("motiondbd: {}\n", text::SafeText(message)).c_str(), stderr);
    return;
  }
  spdlog::memory_buf_t line;
  MakeLogFormatter(format)->format(
      spdlog::details::log_msg("motiondbd", spdlog::level::critical, message), line);
  std::fwrite(line.data(), 1, line.size(), stderr);
}

namespace {

using json = nlohmann::ordered_json;  // keeps the order of insertion

// Returns JSON text. Invalid UTF-8 becomes U+FFFD. Display control characters are escaped.
template <typename Json>
std::string Dump(const Json& value) {
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  std::string escaped;
  escaped.reserve(text.size());
  for (std::string_view rest = text; !rest.empty();) {
    const text::Character character = text::FirstCharacter(rest);
    if (text::IsDisplayControl(character.code)) {
      escaped += fmt::format("\\u{:04x}", static_cast<std::uint32_t>(character.code));
    } else {
      escaped += rest.substr(0, character.bytes);
    }
    rest.remove_prefix(character.bytes);
  }
  return escaped;
}

// Escapes control characters, quotes and backslashes as in JSON.
std::string OneLine(const std::string& text) {
  std::string quoted = Dump(json(text));
  return quoted.substr(1, quoted.size() - 2);
}

std::string MessageOf(const spdlog::details::log_msg& line) {
  return text::RedactSecrets({line.payload.data(), line.payload.size()});
}

// Returns a plain word, or a quoted string if it is not one word.
std::string FieldText(const json& value) {
  const std::string quoted = Dump(value);
  if (!value.is_string()) return quoted;
  const auto& word = value.get_ref<const std::string&>();
  const bool plain = !word.empty() && quoted.size() == word.size() + 2 &&
                     word.find_first_of(" =") == std::string::npos;
  return plain ? word : quoted;
}

json ToJson(const LogField& field) {
  json value = std::visit([](const auto& content) { return json(content); }, field.second);
  if (value.is_string()) value = text::RedactSecrets(value.get_ref<const std::string&>());
  return value;
}

void Collect(const LogFields* fields, json& object) {
  if (fields == nullptr) return;
  Collect(fields->outer(), object);
  for (const LogField& field : fields->fields()) object[field.first] = ToJson(field);
}

// Returns the fields of this thread, outer scopes first. An inner field replaces an outer one with
// the same name.
json CurrentFields() {
  json object = json::object();
  Collect(LogFields::Current(), object);
  return object;
}

class TextFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& line, spdlog::memory_buf_t& out) override {
    head_.format(line, out);
    std::string tail = OneLine(MessageOf(line));
    const json fields = CurrentFields();
    for (const auto& [name, value] : fields.items()) {
      tail += fmt::format(" {}={}", name, FieldText(value));
    }
    tail += '\n';
    out.append(tail.data(), tail.data() + tail.size());
  }
  std::unique_ptr<formatter> clone() const override { return std::make_unique<TextFormatter>(); }

 private:
  spdlog::pattern_formatter head_{"%Y-%m-%dT%H:%M:%S.%e%z %^%l%$ ",
                                  spdlog::pattern_time_type::local, ""};
};

class JsonFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& line, spdlog::memory_buf_t& out) override {
    const auto since_epoch = line.time.time_since_epoch();
    const auto seconds = std::chrono::floor<std::chrono::seconds>(since_epoch);
    const auto milliseconds =
        std::chrono::duration_cast<std::chrono::milliseconds>(since_epoch - seconds);
    const auto level = spdlog::level::to_string_view(line.level);
    nlohmann::ordered_json object;
    object["time"] =
        fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                    fmt::gmtime(static_cast<std::time_t>(seconds.count())), milliseconds.count());
    object["level"] = std::string(level.data(), level.size());
    object["message"] = MessageOf(line);
    object.update(CurrentFields());
    const std::string text = Dump(object) + "\n";
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<formatter> clone() const override { return std::make_unique<JsonFormatter>(); }
};

}  // namespace

std::unique_ptr<spdlog::formatter> MakeLogFormatter(LogFormat format) {
  if (format == LogFormat::kJson) return std::make_unique<JsonFormatter>();
  return std::make_unique<TextFormatter>();
}

}  // namespace motiondb::server
