#include <algorithm>
#include <string>

#include "server/settings/groups.h"
#include "server/settings/options.h"
#include "server/settings/process_limits.h"

namespace motiondb::server {

namespace {

// Of the server's memory, what calls may reserve: one part in so many, but not less than this.
constexpr std::int64_t kMemoryShare = 5;
constexpr std::int64_t kLeastCallMemory = std::int64_t{80} << 20;

template <typename Count>
void AddLimit(CLI::App& app, const std::string& name, Count& limit, int least, int most,
              const std::string& description) {
  AddCount(app, name, limit, least, most, description)->group("Limits");
}

// One client may have a quarter of what all may, so that four are needed to keep the others out.
// `whose` tells what one client is: a call is counted before its token is looked at.
void AddCallLimit(CLI::App& app, const std::string& name, CallLimit& limit, const std::string& what,
                  const std::string& whose = "client: a token or certificate, else an address") {
  app.add_option_function<int>(
         name,
         [&limit](int count) { limit = {.in_all = count, .per_client = std::max(1, count / 4)}; },
         "Most " + what + " under way; a quarter of them for one " + whose)
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
  // A small container must survive clients that use all they may.
  const std::int64_t share = (MemoryLimit() / kMemoryShare) >> 20 << 20;
  calls.message_memory_bytes =
      std::clamp(share, kLeastCallMemory, std::int64_t{calls.message_memory_bytes});
  AddMebibytes(app, "--max-file-mib", settings.server.engine.max_file_bytes,
               "Largest motion file taken, with its skeleton")
      ->group("Limits");
  AddMebibytes(app, "--max-message-mib", settings.server.max_message_bytes, "Largest request taken")
      ->group("Limits");
  AddMebibytes(
      app, "--message-memory-mib", calls.message_memory_bytes,
      "Memory for calls: requests as they come in and as read, files, motion, states, results and "
      "responses, half of it for one client. If not set, a fifth of the memory that the machine "
      "and its control groups give the server, from 80 to 512",
      1 << 20)
      ->group("Limits");
  AddLimit(
      app, "--max-frames", engine.max_frames, 2, 100'000'000,
      "Longest clip or observation, in frames: at its own frame rate, and at the database's; of "
      "more than 34 markers as many fewer");
  AddLimit(app, "--max-databases", engine.max_databases, 1, 1'000'000, "Most databases");
  AddLimit(app, "--max-database-clips", engine.quota.clip_count, 1, 100'000'000,
           "Most clips in one database");
  AddLimit(app, "--max-database-frames", engine.quota.frame_count, 2, 1'000'000'000,
           "Most frames in one database; served, a frame of 34 markers takes 1.2 KB of memory");
  AddMebibytes(app, "--max-database-mib", engine.quota.byte_count,
               "Most bytes of clips in one database", 1 << 30)
      ->group("Limits");
  AddCallLimit(app, "--max-calls", calls.calls, "calls",
               "address; behind a proxy all calls come from the proxy's");
  AddCallLimit(app, "--max-heavy-calls", calls.heavy,
               "heavy calls (ingests, exports, plans, series of predictions, backups, queries of "
               "over 1 MiB or of a long motion)");
  AddCallLimit(app, "--max-streams", calls.streams, "streams of frames");
  AddSeconds(app, "--call-time-limit", calls.longest_call, 1, 86400,
             "Time after which a call ends, but for streams of frames, waits for an operation and "
             "backups, restores and checks of the store")
      ->group("Limits");
  AddSeconds(app, "--silence-limit", calls.longest_silence, 1, 86400,
             "Time for which the client of a stream may send or take nothing; before its first "
             "message at most 10 s")
      ->group("Limits");
}

void CheckLimitSettings(const Settings& settings, std::vector<absl::Status>& problems) {
  const auto memory = static_cast<std::size_t>(settings.server.calls.message_memory_bytes);
  const auto message = static_cast<std::size_t>(settings.server.max_message_bytes);
  if (memory < 2 * message) {
    problems.push_back(absl::InvalidArgumentError(
        "message-memory-mib: less than twice max-message-mib, which the largest request may take "
        "once it is read"));
  }
  if (memory < settings.server.engine.max_file_bytes + message) {
    problems.push_back(absl::InvalidArgumentError(
        "message-memory-mib: less than max-file-mib and max-message-mib together, so the largest "
        "file would never come in"));
  }
}

}  // namespace motiondb::server
