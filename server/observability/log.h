// The server's log, and the facts that its lines carry.
#pragma once

#include <spdlog/formatter.h>

#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace motiondb::server {

// Facts that every log line carries beside its message while they hold on a thread: the request it
// is about, for one. JSON lines have them as members, text lines as `name=value` at the end.

using LogField = std::pair<std::string, std::variant<std::string, double>>;

// Holds on the thread that made it, within the braces that it stands in. May be nested.
class LogFields {
 public:
  // LogFields fields{{"request_id", id}};
  LogFields(std::initializer_list<LogField> fields);
  ~LogFields();
  LogFields(const LogFields&) = delete;
  LogFields& operator=(const LogFields&) = delete;

  // The innermost of this thread; null where there is none.
  static const LogFields* Current();
  const std::vector<LogField>& fields() const { return fields_; }
  const LogFields* outer() const { return outer_; }

 private:
  const std::vector<LogField> fields_;
  const LogFields* const outer_;
};

// The server's log, on standard error. A line looks as text for a person, or as one JSON object for
// a machine. Either way it is one line of valid UTF-8, whatever the message.
enum class LogFormat { kText, kJson };

// Once, before anything is logged. `level`: debug, info, warning, error or off.
void StartLog(LogFormat format, const std::string& level);

// Says on standard error what is to be seen whatever the level of the log: why the program ends, or
// that it is open to all. A line of text that begins with the program's name, or a line of JSON of
// the level critical.
void Tell(LogFormat format, const std::string& message);

// For spdlog::set_formatter. What it makes carries the LogFields of the thread that logs, so the
// logger must not be asynchronous.
std::unique_ptr<spdlog::formatter> MakeLogFormatter(LogFormat format);

}  // namespace motiondb::server
