#include "server/observability/log_fields.h"

namespace motiondb::server {
namespace {

thread_local const LogFields* current = nullptr;

}  // namespace

LogFields::LogFields(std::vector<LogField> fields) : fields_(std::move(fields)), outer_(current) {
  current = this;
}

LogFields::~LogFields() { current = outer_; }

const LogFields* LogFields::Current() { return current; }

}  // namespace motiondb::server
