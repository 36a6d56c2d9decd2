// The server's log, and the fields of its lines.
#pragma once

#include <spdlog/formatter.h>

#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace motiondb::server {

using LogField = std::pair<std::string, std::variant<std::string, double>>;

// Adds fields, such as the request id, to every log line of this thread during its lifetime. Scopes
// may be nested. JSON lines have the fields as members, text lines as `name=value` at the end.
class LogFields {
 public:
  // LogFields fields{{"request_id", id}};
  LogFields(std::initializer_list<LogField> fields);
  ~LogFields();
  LogFields(const LogFields&) = delete;
  LogFields& operator=(const LogFields&) = delete;

  // Returns the innermost scope of this thread; null if there is none.
  static const LogFields* Current();
  const std::vector<LogField>& fields() const { return fields_; }
  const LogFields* outer() const { return outer_; }

 private:
  const std::vector<LogField> fields_;
  const LogFields* const outer_;
};

// Format of a log line: text, or one JSON object. Each event is one line of valid UTF-8.
enum class LogFormat { kText, kJson };

// Logs to standard error. Call once, before any log line. `level`: debug, info, warning, error or
// off.
void StartLog(LogFormat format, const std::string& level);

// Writes to standard error at any log level: why the program ends, or that it is insecure. A text
// line begins with the program's name; a JSON line has the level critical.
void PrintAlways(LogFormat format, const std::string& message);

// Returns a formatter for spdlog::set_formatter. It adds the LogFields of the calling thread, so
// the logger must not be asynchronous.
std::unique_ptr<spdlog::formatter> MakeLogFormatter(LogFormat format);

}  // namespace motiondb::server
