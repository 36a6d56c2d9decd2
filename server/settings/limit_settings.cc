#include <algorithm>
#include <functional>
#include <string>

#include "server/settings/groups.h"
#include "server/settings/process_limits.h"

namespace motiondb::server {

namespace {

// Memory of calls: 1/kMemoryShare of the memory of the server, at least kMinCallMemory bytes.
constexpr std::int64_t kMemoryShare = 5;
constexpr std::int64_t kMinCallMemory = std::int64_t{80} << 20;
// A message with a block of a file, which has at most 1 MiB, is a little larger.
constexpr int kMinMessageMebibytes = 2;

template <typename Count>
void AddLimit(CLI::App& app, const std::string& name, Count& limit, int min, int max,
              const std::string& description) {
  AddCount(app, name, limit, min, max, description)->group("Limits");
}

// The limit of one client is a quarter of the limit of all, so one client cannot block the others.
CallLimit LimitOf(int count) { return {.in_all = count, .per_client = std::max(1, count / 4)}; }

void AddCallLimit(CLI::App& app, const std::string& name, const CallLimit& limit,
                  const std::function<void(int)>& set, const std::string& description) {
  app.add_option_function<int>(name, set, description)
      ->type_name("N")
      ->check(WholeNumber())
      ->check(CLI::Range(1, 1'000'000))
      ->default_str(std::to_string(limit.in_all))
      ->group("Limits");
}

}  // namespace

void AddLimitSettings(CLI::App& app, Settings& settings) {
  EngineOptions& engine = settings.server.engine;
  CallLimitOptions& calls = settings.server.calls;
  // In a small container, clients that use all of their limits must not exhaust the memory.
  const std::int64_t share = (MemoryLimit() / kMemoryShare) >> 20 << 20;
  calls.message_memory_bytes =
      std::clamp(share, kMinCallMemory, std::int64_t{calls.message_memory_bytes});
  AddMebibytes(app, "--max-file-mib", settings.server.engine.max_file_bytes,
               "Maximum size of a motion file with its skeleton file")
      ->group("Limits");
  AddMebibytes(app, "--max-message-mib", settings.server.max_message_bytes,
               "Maximum size of a message of a request; files are sent in blocks of 1 MiB", 1024,
               kMinMessageMebibytes)
      ->group("Limits");
  AddMebibytes(
      app, "--message-memory-mib", calls.message_memory_bytes,
      "Memory of all calls: requests, files, motion, states, results and responses; half of it "
      "for one client. If not set: a fifth of the memory available to the server (machine and "
      "control groups), from 80 to 512",
      1 << 20)
      ->group("Limits");
  AddLimit(app, "--max-frames", engine.max_frames, 2, 100'000'000,
           "Maximum length of a clip or observation, in frames at its own frame rate and at the "
           "database's; for more than 34 markers proportionally fewer");
  AddLimit(app, "--max-databases", engine.max_databases, 1, 1'000'000,
           "Maximum number of databases");
  AddLimit(app, "--max-database-clips", engine.quota.clip_count, 1, 100'000'000,
           "Maximum number of clips in one database");
  AddLimit(app, "--max-database-frames", engine.quota.frame_count, 2, 1'000'000'000,
           "Maximum number of frames in one database; a frame of 34 markers uses 1.2 KB of memory");
  AddMebibytes(app, "--max-database-mib", engine.quota.byte_count,
               "Maximum size of the clips in one database", 1 << 30)
      ->group("Limits");
  AddCallLimit(
      app, "--max-calls", calls.calls,
      [&calls](int count) {
        calls.calls = LimitOf(count);
        calls.streams = LimitOf(std::max(1, count / 4));
      },
      "Maximum number of calls in flight; a quarter of them may be Observe, WatchStream and "
      "WatchDatabase streams. One address (of the proxy, if there is one) may have a quarter of "
      "the calls, one client a quarter of the streams");
  AddCallLimit(
      app, "--max-heavy-calls", calls.heavy, [&calls](int count) { calls.heavy = LimitOf(count); },
      "Maximum number of heavy calls (ingests, exports, plans, series of predictions, backups, "
      "queries of more than 1 MiB or with a long motion) in flight; a quarter of it for one "
      "client (token or certificate, otherwise address)");
  AddSeconds(app, "--call-time-limit", calls.max_call_time, 1, 86400,
             "Maximum duration of a call; not for streams, WaitOperation, and backup, restore and "
             "verification of the store")
      ->group("Limits");
  AddSeconds(app, "--silence-limit", calls.idle_limit, 1, 86400,
             "Idle timeout of a stream, in each direction; at most 10 s before its first message")
      ->group("Limits");
}

void CheckLimitSettings(const Settings& settings, std::vector<absl::Status>& problems) {
  const auto memory = static_cast<std::size_t>(settings.server.calls.message_memory_bytes);
  const auto message = static_cast<std::size_t>(settings.server.max_message_bytes);
  if (memory < 2 * message) {
    problems.push_back(absl::InvalidArgumentError(
        "message-memory-mib: expected at least twice max-message-mib, because a parsed request may "
        "need twice its size"));
  }
  if (memory < settings.server.engine.max_file_bytes + message) {
    problems.push_back(absl::InvalidArgumentError(
        "message-memory-mib: expected at least max-file-mib plus max-message-mib, so that the "
        "largest file fits"));
  }
}

}  // namespace motiondb::server
