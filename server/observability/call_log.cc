#include "server/observability/call_log.h"

#include <spdlog/spdlog.h>

#include <cmath>

#include "server/observability/log_fields.h"

namespace motiondb::server {
namespace {

spdlog::level::level_enum LevelOf(const EndedCall& call, std::chrono::duration<double> slow) {
  if (IsOwnFault(call.code)) return spdlog::level::err;
  const bool is_slow =
      call.kind == CallKind::kWork && slow.count() > 0 && call.seconds >= slow.count();
  return is_slow ? spdlog::level::warn : spdlog::level::debug;
}

}  // namespace

void LogCall(const EndedCall& call, std::chrono::duration<double> slow) {
  const auto level = LevelOf(call, slow);
  if (!spdlog::should_log(level)) return;
  const LogFields fields{{"request_id", call.request_id},
                         {"method", call.method},
                         {"code", std::string(CodeName(call.code))},
                         {"milliseconds", std::round(call.seconds * 1e6) / 1e3},
                         {"peer", call.peer}};
  const char* const what = level == spdlog::level::err    ? "call failed"
                           : level == spdlog::level::warn ? "slow call"
                                                          : "call";
  if (call.message.empty()) {
    spdlog::log(level, "{}", what);
  } else {
    spdlog::log(level, "{}: {}", what, call.message);
  }
}

}  // namespace motiondb::server
