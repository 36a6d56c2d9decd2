#include "client/cli/status_text.h"

#include <fmt/format.h>
#include <motiondb/v1/store.pb.h>

#include "client/cli/resource_name.h"
#include "client/cli/table.h"

namespace motiondb::client {
namespace {

// More would push the rest off the screen; --json has them all.
constexpr int kShownDamages = 5;

std::string ConnectionText(const v1::GetServerStatusResponse& status) {
  return fmt::format("{}, {}", status.encrypted() ? "encrypted" : "not encrypted",
                     status.authenticated() ? "callers say who they are"
                                            : "anybody who reaches it may do anything");
}

std::string CallsText(const v1::GetServerStatusResponse& status) {
  return fmt::format("{} ended, {} of them failed by the server's fault; {} under way",
                     status.call_count(), status.failed_call_count(), status.open_call_count());
}

// A bar of ten, how far it is, and what is being done.
std::string WorkText(const v1::DatabaseStatus& database) {
  if (database.operation().empty()) return "";
  const int full = static_cast<int>(database.progress() * 10 + 0.5);
  return fmt::format("[{}{}] {:.0f} %  {}", std::string(static_cast<std::size_t>(full), '#'),
                     std::string(static_cast<std::size_t>(10 - full), '.'),
                     database.progress() * 100, database.stage());
}

std::string DatabasesText(const v1::GetServerStatusResponse& status) {
  if (status.databases().empty()) return "no databases yet: make one with `motiondb create DB`\n";
  Table table({{"DATABASE"},
               {"CLIPS", Align::kRight},
               {"FRAMES", Align::kRight},
               {"MODEL", Align::kRight},
               {"AGE", Align::kRight},
               {"BEING REBUILT"}});
  for (const v1::DatabaseStatus& database : status.databases()) {
    const bool has_model = database.model_version() > 0;
    table.AddRow({ShortName(database.name()), std::to_string(database.clip_count()),
                  std::to_string(database.frame_count()),
                  has_model ? std::to_string(database.model_version()) : "none",
                  has_model ? DurationText(database.model_age().seconds()) : "",
                  WorkText(database)});
  }
  return table.ToString();
}

std::string DamagesText(const v1::GetServerStatusResponse& status) {
  const int count = status.damages_size();
  if (count == 0) return "";
  std::string text = fmt::format("\ndamaged: {} (`motiondb verify` reads everything)\n", count);
  for (int i = 0; i < std::min(count, kShownDamages); ++i) {
    const v1::Damage& damage = status.damages(i);
    const std::string what = damage.resource().empty() ? "the store's file" : damage.resource();
    text += fmt::format("  {}: {}\n", what, damage.description());
  }
  if (count > kShownDamages) text += fmt::format("  and {} more\n", count - kShownDamages);
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
  table.AddRow({"motiondbd", fmt::format("{}, {}", status.version(),
                                         status.serving() ? "serving" : "draining")});
  table.AddRow({"up", DurationText(now_us / 1'000'000 - status.start_time().seconds())});
  table.AddRow({"connections", ConnectionText(status)});
  table.AddRow({"calls", CallsText(status)});
  table.AddRow({"streams of frames", std::to_string(status.open_stream_count())});
  table.AddRow({"waiting for a thread", std::to_string(status.queued_call_count())});
  table.AddRow({"memory", BytesText(status.memory_bytes())});
  table.AddRow({"store", fmt::format("{}, log {}", BytesText(status.store_bytes()),
                                     BytesText(status.log_bytes()))});
  return table.ToString() + "\n" + DatabasesText(status) + DamagesText(status);
}

}  // namespace motiondb::client
