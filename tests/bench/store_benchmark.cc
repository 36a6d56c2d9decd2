// Measures a server on PostgreSQL beside one on a file, in turn: queries, ingestion, and the start
// with a large database. Both servers and their clients are in one process; PostgreSQL is another
// one on the same machine. Ratios are medians of the rounds.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/engine/engine.h"
#include "server/engine/snapshot.h"
#include "storage/migration/migrate_store.h"
#include "storage/postgres/postgres_motion_store.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/client_load.h"
#include "tests/bench/large_store.h"
#include "tests/bench/served_motion.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

using Clock = std::chrono::steady_clock;

constexpr char kStored[] = "database1";
constexpr int kFrameRate = 60;
constexpr int kWindow = 24;  // frames
constexpr std::uint64_t kStoreSeed = 1;

struct StoreOptions {
  std::string postgres;  // URL of an empty database
  VariedSize size;
  int rounds = 7;
  int jobs = 1;
};

enum Engine : std::size_t { kFile, kPostgres };
// Seconds by engine and round.
using Times = std::array<std::vector<double>, 2>;

double Median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// Runs both in turn, in each round; the first round is not counted.
absl::StatusOr<Times> InTurn(int rounds,
                             const std::function<absl::StatusOr<double>(Engine, int)>& measure) {
  Times times;
  for (int round = 0; round <= rounds; ++round) {
    for (std::size_t i = 0; i < 2; ++i) {
      const auto engine = static_cast<Engine>(round % 2 == 0 ? i : 1 - i);
      MOTIONDB_ASSIGN_OR_RETURN(const double seconds, measure(engine, round));
      if (round > 0) times[engine].push_back(seconds);
    }
  }
  return times;
}

// A row of costs: the ratio is the median of the rounds' ratios.
BenchRow PairedRow(const std::string& name, const Times& times, Bar bar) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < times[kFile].size(); ++i) {
    ratios.push_back(times[kPostgres][i] / times[kFile][i]);
  }
  BenchRow row = RatioRow(name + ", PostgreSQL", 1e3 * Median(times[kPostgres]), "a file",
                          1e3 * Median(times[kFile]), "ms", bar);
  row.ratio = Median(ratios);
  row.note = fmt::format("paired ratios from {:.2f} to {:.2f}", std::ranges::min(ratios),
                         std::ranges::max(ratios));
  return row;
}

using Servers = std::array<std::unique_ptr<ServedMotion>, 2>;

absl::StatusOr<BenchRow> QueryRow(const StoreOptions& options, Servers& servers,
                                  const std::vector<MotionBytes>& clips) {
  std::vector<v1::RecognizeRequest> requests;
  for (const MotionBytes& clip : clips) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto markers,
                              servers[kFile]->Represent(kStored, clip, kFrameRate));
    for (int f = 0; f + kWindow <= markers.frame_count(); f += kWindow) {
      v1::RecognizeRequest& request = requests.emplace_back();
      request.set_database(fmt::format("databases/{}", kStored));
      *request.mutable_observation()->mutable_markers() = Cut(markers, f, kWindow);
    }
  }
  MOTIONDB_ASSIGN_OR_RETURN(
      const Times times, InTurn(options.rounds, [&](Engine engine, int) -> absl::StatusOr<double> {
        std::vector<std::unique_ptr<LoadClient>> client;
        client.push_back(NewRecognizeClient(servers[engine]->address(), requests, 0));
        MOTIONDB_ASSIGN_OR_RETURN(const Load load, RunConcurrently(client, 20, Seconds(1)));
        return load.LatencyQuantile(0.5) / 1e3;
      }));
  return PairedRow("recognize over gRPC, p50", times, AtMost(1.1));
}

absl::StatusOr<BenchRow> IngestRowOf(const StoreOptions& options, Servers& servers,
                                     const std::vector<MotionBytes>& clips) {
  MOTIONDB_ASSIGN_OR_RETURN(
      const Times times,
      InTurn(options.rounds, [&](Engine engine, int round) -> absl::StatusOr<double> {
        ServedMotion& served = *servers[engine];
        const std::string database = fmt::format("ingest-{}", round);
        MOTIONDB_RETURN_IF_ERROR(served.Create(database));
        v1::IngestClipResponse last;
        const auto begin = Clock::now();
        for (const MotionBytes& clip : clips) {
          MOTIONDB_ASSIGN_OR_RETURN(last, served.Ingest(database, clip));
        }
        const Seconds seconds = Clock::now() - begin;
        MOTIONDB_RETURN_IF_ERROR(served.Await(last.operation().name()));
        return seconds.count() / static_cast<double>(clips.size());
      }));
  // A rate of at least 0.7 of that of the file.
  BenchRow row = PairedRow("ingest of a clip until acknowledged", times, AtMost(1 / 0.7));
  row.note += fmt::format("; the rate is {:.2f} of that of the file", 1 / row.ratio);
  return row;
}

absl::StatusOr<BenchRow> StartRow(const StoreOptions& options, const std::string& file) {
  const auto start = [&](Engine engine, int) -> absl::StatusOr<double> {
    const auto begin = Clock::now();
    std::unique_ptr<storage::MotionStore> store;
    if (engine == kFile) {
      MOTIONDB_ASSIGN_OR_RETURN(store, storage::SqliteMotionStore::Open(file));
    } else {
      MOTIONDB_ASSIGN_OR_RETURN(store, storage::PostgresMotionStore::Open(options.postgres));
    }
    MOTIONDB_ASSIGN_OR_RETURN(const auto engine_of, server::Engine::Open(std::move(store), {}));
    MOTIONDB_ASSIGN_OR_RETURN(const auto live, engine_of->FindDatabase(kLargeDatabase));
    MOTIONDB_RETURN_IF_ERROR(engine_of->CurrentModel(*live).status());
    return Seconds(Clock::now() - begin).count();
  };
  MOTIONDB_ASSIGN_OR_RETURN(const Times times, InTurn(options.rounds, start));
  return PairedRow(fmt::format("start with {} frames", options.size.frames), times, AtMost(4));
}

absl::StatusOr<BenchTable> Compare(const StoreOptions& options) {
  BenchTable table{"stores", {}, {}};
  const TemporaryDirectory directory;
  // First: the migration needs an empty database.
  const std::string large = directory / "large.db";
  const auto parallel = RunOnThreads(options.jobs);
  MOTIONDB_RETURN_IF_ERROR(MakeLargeStore(large, options.size, kStoreSeed, parallel).status());
  const auto begin = Clock::now();
  MOTIONDB_RETURN_IF_ERROR(storage::MigrateStore(large, options.postgres, {}, {}));
  const double migrated = Seconds(Clock::now() - begin).count();
  MOTIONDB_ASSIGN_OR_RETURN(table.rows.emplace_back(), StartRow(options, large));

  MOTIONDB_ASSIGN_OR_RETURN(const auto train, ReadClips("database1.train"));
  MOTIONDB_ASSIGN_OR_RETURN(const auto test, ReadClips("database1.test"));
  Servers servers;
  MOTIONDB_ASSIGN_OR_RETURN(servers[kFile], ServedMotion::Start());
  MOTIONDB_ASSIGN_OR_RETURN(auto store, storage::PostgresMotionStore::Open(options.postgres));
  MOTIONDB_RETURN_IF_ERROR(store->DeleteDatabase(kLargeDatabase));
  MOTIONDB_ASSIGN_OR_RETURN(servers[kPostgres], ServedMotion::StartWith(std::move(store)));
  for (const auto& served : servers) {
    MOTIONDB_RETURN_IF_ERROR(served->Create(kStored));
    MOTIONDB_RETURN_IF_ERROR(served->Fill(kStored, train));
  }
  MOTIONDB_ASSIGN_OR_RETURN(table.rows.emplace_back(), QueryRow(options, servers, test));
  MOTIONDB_ASSIGN_OR_RETURN(table.rows.emplace_back(), IngestRowOf(options, servers, test));
  table.notes.push_back(fmt::format(
      "stores: both servers and their clients in one process, PostgreSQL on the same machine; {} "
      "rounds, in turn; the migration of {} frames to PostgreSQL took {:.1f} s",
      options.rounds, options.size.frames, migrated));
  return table;
}

int Main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::off);
  BenchProgram program("Compares PostgreSQL with a file as the store.", "motiondb_bench_stores");
  StoreOptions options;
  program.app()
      .add_option("--postgres", options.postgres, "URL of an empty PostgreSQL database")
      ->required();
  program.AddSize(options.size);
  program.app()
      .add_option("--rounds", options.rounds, "Rounds of each measurement")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  program.AddJobs(options.jobs, "Threads that make the large database");
  return program.Run(argc, argv, [&] { return Compare(options); });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
