// Facts that every log line carries beside its message while they hold on a thread: the request it
// is about, for one. JSON lines have them as members, text lines as `name=value` at the end.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace motiondb::server {

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

}  // namespace motiondb::server
