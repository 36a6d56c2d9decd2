#include "server/migrate_command.h"

#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>

#include "storage/migration/migrate_store.h"
#include "storage/store_url.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

constexpr std::string_view kMigrateHelp =
    R"(Copy a whole store into an empty one, without a server; stop the servers of both first.

Usage: motiondbd migrate FROM TO

  FROM, TO   the file of a store, or postgresql://USER@HOST/NAME

All rows are copied, then compared bit by bit; only then can servers open TO. After an interruption
at any point, run the same command again: it continues. FROM does not change.
)";

volatile std::sig_atomic_t is_interrupted = 0;

void Interrupt(int) { is_interrupted = 1; }

// Prints the progress, at most once a second and at each change of the phase.
class ProgressLines {
 public:
  void Show(const storage::MigrationProgress& now) {
    const bool is_new = !is_begun_ || now.phase != phase_;
    const auto time = std::chrono::steady_clock::now();
    if (!is_new && time < next_) return;
    if (!is_begun_ && now.is_continued) fmt::print("continuing an interrupted migration\n");
    is_begun_ = true;
    phase_ = now.phase;
    next_ = time + std::chrono::seconds(1);
    const double megabytes = static_cast<double>(now.bytes) / 1e6;
    switch (now.phase) {
      case storage::MigrationProgress::Phase::kCopy:
        fmt::print("copied {:.1f} MB\n", megabytes);
        break;
      case storage::MigrationProgress::Phase::kIndex:
        fmt::print("copied {:.1f} MB; making the search index\n", megabytes);
        break;
      case storage::MigrationProgress::Phase::kCompare:
        fmt::print("compared {:.1f} MB\n", megabytes);
        break;
      case storage::MigrationProgress::Phase::kPublish:
        fmt::print("compared {:.1f} MB: all rows are equal\n", megabytes);
        break;
    }
    std::fflush(stdout);
  }

 private:
  bool is_begun_ = false;
  storage::MigrationProgress::Phase phase_{};
  std::chrono::steady_clock::time_point next_;
};

absl::Status MigrateWithoutExceptions(const std::string& from, const std::string& to) {
  try {
    ProgressLines lines;
    return storage::MigrateStore(
        from, to, [&](const storage::MigrationProgress& now) { lines.Show(now); },
        [] { return is_interrupted != 0; });
  } catch (const std::exception& error) {
    return absl::ResourceExhaustedError(fmt::format("cannot migrate: {}", error.what()));
  }
}

}  // namespace

int RunMigrate(std::span<const char* const> arguments) {
  const bool asks_for_help = arguments.size() == 2 && std::string_view(arguments[1]) == "--help";
  if (asks_for_help) {
    fmt::print("{}", kMigrateHelp);
    return 0;
  }
  if (arguments.size() != 3 || arguments[1][0] == '-' || arguments[2][0] == '-') {
    fmt::print(stderr,
               "motiondbd: expected two stores: motiondbd migrate FROM TO\n"
               "Try `motiondbd migrate --help`.\n");
    return 2;
  }
  std::signal(SIGINT, Interrupt);
  std::signal(SIGTERM, Interrupt);
  const std::string from = arguments[1];
  const std::string to = arguments[2];
  const absl::Status migrated = MigrateWithoutExceptions(from, to);
  if (!migrated.ok()) {
    fmt::print(stderr, "motiondbd: {}\n", text::SafeText(std::string(migrated.message())));
    return 1;
  }
  fmt::print("migrated {} to {}\n", text::SafeText(storage::WithoutPassword(from)),
             text::SafeText(storage::WithoutPassword(to)));
  return 0;
}

}  // namespace motiondb::server
