#include "client/cli/server_text.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <google/protobuf/util/time_util.h>
#include <motiondb/v1/access.pb.h>
#include <motiondb/v1/server.pb.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

// Maximum numbers of rows, so that the status fits on a screen. --json prints all.
constexpr int kShownCorruptions = 5;
constexpr std::size_t kShownMethods = 10;
constexpr std::size_t kShownDatabases = 12;

double SecondsOf(const google::protobuf::Duration& duration) {
  using google::protobuf::util::TimeUtil;
  return static_cast<double>(TimeUtil::DurationToMicroseconds(duration)) * 1e-6;
}

std::string ConnectionText(const v1::GetServerStatusResponse& status) {
  std::string wire = status.encrypted() ? "encrypted" : "not encrypted";
  if (status.has_certificate_end_time()) {
    const auto end = static_cast<std::time_t>(status.certificate_end_time().seconds());
    wire += fmt::format(", certificate valid until {:%Y-%m-%d %H:%M} UTC", fmt::gmtime(end));
  }
  return fmt::format(
      "{}, {}", wire,
      status.authenticated() ? "authentication: required" : "authentication: DISABLED");
}

std::string ServingText(const v1::GetServerStatusResponse& status) {
  if (!status.serving()) return "draining";
  if (status.not_ready_reason().empty()) return "serving";
  return fmt::format("serving, but not ready: {}", status.not_ready_reason());
}

std::string CallsText(const v1::GetServerStatusResponse& status) {
  return fmt::format("{} ended, {} of them with a server error; {} in flight", status.call_count(),
                     status.failed_call_count(), status.open_call_count());
}

std::string WaitingText(const v1::GetServerStatusResponse& status) {
  std::string text =
      fmt::format("{}; {} threads", status.queued_call_count(), status.request_thread_count());
  if (status.running_heavy_call_count() > 0) {
    text += "; " + CountText(status.running_heavy_call_count(), "heavy call") + " running";
  }
  return text;
}

std::string ProcessText(const v1::GetServerStatusResponse& status) {
  return fmt::format("{} of memory, {} of CPU time, {} threads, {} of {} files open",
                     BytesText(status.memory_bytes()), DurationText(status.cpu_time().seconds()),
                     status.thread_count(), status.open_file_count(), status.open_file_limit());
}

std::string StoreText(const v1::GetServerStatusResponse& status) {
  std::string text =
      fmt::format("{}, log {}", BytesText(status.store_bytes()), BytesText(status.log_bytes()));
  if (status.failed_write_count() > 0) {
    text += ", " + CountText(status.failed_write_count(), "failed write");
  }
  if (!status.has_disk_bytes()) return text;
  return text + fmt::format("; {} of {} free on its disk", BytesText(status.disk_free_bytes()),
                            BytesText(status.disk_bytes()));
}

// Milliseconds with three digits.
Cell Latency(const google::protobuf::Duration& duration) {
  const double milliseconds = 1000 * SecondsOf(duration);
  return {milliseconds, milliseconds < 10 ? 2 : milliseconds < 100 ? 1 : 0};
}

// "NOT_FOUND 3, INTERNAL 1".
std::string ErrorsText(const v1::MethodStatus& method) {
  std::string text;
  for (const v1::CodeCount& error : method.errors()) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ",
                        absl::StatusCodeToString(static_cast<absl::StatusCode>(error.code())),
                        error.call_count());
  }
  return text;
}

// Methods, most calls first.
std::string MethodsText(const v1::GetServerStatusResponse& status) {
  if (status.methods().empty()) return "";
  std::vector<const v1::MethodStatus*> methods;
  for (const v1::MethodStatus& method : status.methods()) methods.push_back(&method);
  std::stable_sort(methods.begin(), methods.end(),
                   [](const auto* a, const auto* b) { return a->call_count() > b->call_count(); });
  Table table({{"CALLS OF"},
               {"ENDED", Align::kRight},
               {"P50 (ms)", Align::kRight},
               {"P95 (ms)", Align::kRight},
               {"P99 (ms)", Align::kRight},
               {"ERRORS"}});
  const std::size_t shown = std::min(methods.size(), kShownMethods);
  for (std::size_t i = 0; i < shown; ++i) {
    const v1::MethodStatus& method = *methods[i];
    table.AddRow({method.method(), method.call_count(), Latency(method.p50_time()),
                  Latency(method.p95_time()), Latency(method.p99_time()), ErrorsText(method)});
  }
  std::string text = "\n" + table.ToString();
  if (methods.size() > shown) {
    text += fmt::format("and {} more methods\n", methods.size() - shown);
  }
  return text;
}

// Returns the databases in order of name, or the most active ones if there are too many.
std::vector<const v1::DatabaseStatus*> ShownDatabases(const v1::GetServerStatusResponse& status) {
  std::vector<const v1::DatabaseStatus*> databases;
  for (const v1::DatabaseStatus& database : status.databases()) databases.push_back(&database);
  if (databases.size() <= kShownDatabases) return databases;
  const auto activity = [](const v1::DatabaseStatus* database) {
    return std::tuple(!database->operation().empty(), database->open_stream_count(),
                      database->stored_frame_count());
  };
  std::ranges::stable_sort(databases, std::greater(), activity);
  databases.resize(kShownDatabases);
  return databases;
}

std::string DatabasesText(const v1::GetServerStatusResponse& status) {
  if (status.databases().empty()) return "no databases; create one with `motiondb create DB`\n";
  Table table({{"DATABASE"},
               {"CLIPS", Align::kRight},
               {"FRAMES", Align::kRight},
               {"SIZE (MiB)", Align::kRight},
               {"STREAMS", Align::kRight}});
  // Counts of failures and the progress of a rebuild are only shown if there are any.
  Table models({{"MODEL OF"},
                {"VERSION", Align::kRight},
                {"FRAMES", Align::kRight},
                {"AGE (h)", Align::kRight},
                {"BUILT IN (s)", Align::kRight},
                {"REBUILDS", Align::kRight},
                {"TIME (s)", Align::kRight},
                {"FAILED", Align::kRight},
                {"CANCELLED", Align::kRight},
                {"DONE (%)", Align::kRight},
                {"STAGE"}});
  const std::vector<const v1::DatabaseStatus*> shown = ShownDatabases(status);
  for (const v1::DatabaseStatus* const each : shown) {
    const v1::DatabaseStatus& database = *each;
    const std::string name = ShortName(database.name());
    table.AddRow({name, database.clip_count(), database.stored_frame_count(),
                  Cell(static_cast<double>(database.byte_count()) / (1 << 20), 2),
                  database.open_stream_count()});
    // A model that is not stored yet has frames but no version.
    const bool has_model = database.frame_count() > 0;
    const std::string version =
        database.model_version() > 0 ? std::to_string(database.model_version()) : "new";
    const auto some = [](std::int64_t count) { return count > 0 ? Cell(count) : Cell(); };
    models.AddRow(
        {name, has_model ? version : "none", some(database.frame_count()),
         has_model ? Cell(SecondsOf(database.model_age()) / 3600, 2) : Cell(),
         has_model ? Cell(SecondsOf(database.model_build_time()), 2) : Cell(),
         database.succeeded_rebuild_count(),
         database.has_rebuild_time() ? Cell(SecondsOf(database.rebuild_time()), 2) : Cell(),
         Cell(some(database.failed_rebuild_count()).text(), Style::kError),
         some(database.cancelled_rebuild_count()),
         database.operation().empty() ? Cell() : Cell(100 * database.progress(), 0),
         database.operation().empty() ? "" : database.stage()});
  }
  std::string text = table.ToString() + "\n" + models.ToString();
  if (const std::size_t more = static_cast<std::size_t>(status.databases_size()) - shown.size();
      more > 0) {
    text += fmt::format("and {} more databases: `motiondb list`\n", more);
  }
  return text;
}

std::string CorruptionsText(const v1::GetServerStatusResponse& status) {
  const int count = status.corruptions_size();
  if (count == 0) return "";
  std::string text = fmt::format("\ncorrupt: {} (`motiondb verify` checks everything)\n", count);
  for (int i = 0; i < std::min(count, kShownCorruptions); ++i) {
    const v1::Corruption& corruption = status.corruptions(i);
    const std::string what =
        corruption.resource().empty() ? "the store's file" : corruption.resource();
    text += fmt::format("  {}: {}\n", text::DisplayText(what),
                        text::DisplayText(corruption.description()));
  }
  if (count > kShownCorruptions) text += fmt::format("  and {} more\n", count - kShownCorruptions);
  return text;
}

}  // namespace

std::string DurationText(std::int64_t seconds) {
  constexpr std::int64_t kMinute = 60, kHour = 3600, kDay = 86400;
  if (seconds < kMinute) return fmt::format("{} s", std::max<std::int64_t>(0, seconds));
  if (seconds < kHour) return fmt::format("{} min {} s", seconds / kMinute, seconds % kMinute);
  if (seconds < kDay) {
    return fmt::format("{} h {} min", seconds / kHour, seconds % kHour / kMinute);
  }
  return fmt::format("{} d {} h", seconds / kDay, seconds % kDay / kHour);
}

std::string BytesText(std::int64_t bytes) {
  if (bytes < 1024) return fmt::format("{} B", bytes);
  auto amount = static_cast<double>(bytes);
  const char* unit = "B";
  for (const char* larger : {"KiB", "MiB", "GiB", "TiB"}) {
    if (amount < 1024) break;
    amount /= 1024;
    unit = larger;
  }
  return fmt::format("{:.1f} {}", amount, unit);
}

std::string StatusText(const v1::GetServerStatusResponse& status, std::int64_t now_us) {
  Table table({{""}, {""}});
  table.AddRow({"motiondbd", fmt::format("{}, {}", status.version(), ServingText(status))});
  table.AddRow({"up", DurationText(now_us / 1'000'000 - status.start_time().seconds())});
  table.AddRow({"connections", ConnectionText(status)});
  table.AddRow({"calls", CallsText(status)});
  table.AddRow({"streams of frames", std::to_string(status.open_stream_count())});
  table.AddRow({"waiting for a thread", WaitingText(status)});
  table.AddRow({"unauthenticated", CountText(status.authentication_failure_count(), "call")});
  table.AddRow({"process", ProcessText(status)});
  table.AddRow({"store", StoreText(status)});
  return table.ToString() + "\n" + DatabasesText(status) + MethodsText(status) +
         CorruptionsText(status);
}

namespace {

std::string DatabaseWord(const v1::Token& token) {
  return token.database().empty() ? "(all)" : ShortName(token.database());
}

std::string StateText(const v1::Token& token, std::int64_t now_seconds) {
  if (token.has_revoke_time()) return "revoked";
  if (!token.has_expire_time()) return "valid";
  return token.expire_time().seconds() <= now_seconds ? "expired" : "valid";
}

}  // namespace

bool IsValid(const v1::Token& token, std::int64_t now_seconds) {
  return StateText(token, now_seconds) == "valid";
}

Table TokensTable(const std::vector<v1::Token>& tokens, std::int64_t now_seconds) {
  Table table({{"TOKEN"}, {"ROLE"}, {"DATABASE"}, {"STATE"}, {"EXPIRES"}, {"CREATED"}, {"FOR"}});
  for (const v1::Token& token : tokens) {
    const std::string state = StateText(token, now_seconds);
    table.AddRow({ShortName(token.name()), EnumValueText(v1::Role_Name(token.role())),
                  DatabaseWord(token),
                  Cell(state, state == "valid" ? Style::kGood : Style::kWarning),
                  token.has_expire_time() ? TimeText(token.expire_time()) : "never",
                  TimeText(token.create_time()), token.description()});
  }
  return table;
}

std::string TokenText(const v1::Token& token) {
  return fmt::format(
      "{}: {} of {}, {}", token.name(), EnumValueText(v1::Role_Name(token.role())),
      token.database().empty() ? "all databases" : token.database(),
      token.has_expire_time() ? "until " + TimeText(token.expire_time()) : "until it is revoked");
}

Table AuditTable(const v1::ListAuditEntriesResponse& response) {
  Table table({{"TIME"}, {"WHO"}, {"FROM"}, {"CALL"}, {"ON"}, {"ENDED"}, {"REQUEST"}});
  for (const v1::AuditEntry& entry : response.entries()) {
    table.AddRow({TimeText(entry.time()), entry.principal(), entry.peer(), entry.method(),
                  entry.resource(),
                  absl::StatusCodeToString(static_cast<absl::StatusCode>(entry.code())),
                  entry.request_id()});
  }
  return table;
}

}  // namespace motiondb::client
