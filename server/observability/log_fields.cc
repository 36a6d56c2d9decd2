#include "server/observability/log_fields.h"

namespace motiondb::server {
namespace {

thread_local const LogFields* current = nullptr;

}  // namespace

LogFields::LogFields(std::initializer_list<LogField> fields) : fields_(fields), outer_(current) {
  current = this;
}

LogFields::~LogFields() { current = outer_; }

const LogFields* LogFields::Current() { return current; }

}  // namespace motiondb::server
