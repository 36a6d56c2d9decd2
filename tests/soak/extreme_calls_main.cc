// Sends seeded extreme calls to a real motiondbd. One at a time, no call may use more memory than
// 64 MB plus ten times its size. Concurrently, and in a memory cgroup if selected, the server must
// survive.
//   motiondb_extreme_calls --calls 10000 --seed 1
//   motiondb_extreme_calls --calls 10000 --seed 1 --concurrency 64 --cgroup-mib 512
// The database is generated from walking figures (--frames), or is in a store (--store,
// --database).
#include <fmt/format.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "tests/soak/extreme_calls.h"
#include "tests/soak/process_memory.h"
#include "tests/support/child_process.h"
#include "tests/support/project_paths.h"
#include "tests/support/stick_figure.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {
namespace {

constexpr int kSkipped = 77;
constexpr std::int64_t kMaxOfAnyCall = 64'000'000;
constexpr std::int64_t kTimesItsSize = 10;
#ifdef __SANITIZE_ADDRESS__  // freed memory is kept, so memory is not measured
constexpr bool kMemoryCounts = false;
#else
constexpr bool kMemoryCounts = true;
#endif

struct Options {
  int calls = 300;
  unsigned seed = 1;
  int concurrency = 1;
  int cgroup_mib = 0;
  int frames = 3000;
  int largest_kib = 4096;
  std::string store;
  std::string database = "extreme";
  std::string server = MotiondbdProgram();
  std::vector<std::string> server_options;
};

template <typename T>
T Required(absl::StatusOr<T> result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
  return *std::move(result);
}

class Served {
 public:
  Served(const Options& options, const std::string& store) : process_(Arguments(options, store)) {
    constexpr std::string_view kAnnouncement = "motiondbd: listening on ";
    while (address_.empty()) {
      const std::string line = process_.ReadLine();
      if (line.empty()) throw std::runtime_error("motiondbd did not start");
      if (line.starts_with(kAnnouncement)) address_ = line.substr(kAnnouncement.size());
    }
  }
  client::Client Connect() const { return Required(client::Client::Connect({.server = address_})); }
  const std::string& address() const { return address_; }
  pid_t pid() const { return process_.pid(); }
  int Stop() {
    process_.Signal(SIGTERM);
    return process_.Wait();
  }

 private:
  static std::vector<std::string> Arguments(const Options& options, const std::string& store) {
    std::vector<std::string> arguments{options.server, "--store",         store,
                                       "--listen",     "127.0.0.1:0",     "--log-level",
                                       "error",        "--rebuild-delay", "0.3"};
    if (options.cgroup_mib > 0) {
      arguments.insert(arguments.end(), {"--message-memory-mib",
                                         std::to_string(std::max(96, options.cgroup_mib / 4))});
    }
    arguments.insert(arguments.end(), options.server_options.begin(), options.server_options.end());
    return arguments;
  }

  ChildProcess process_;
  std::string address_;
};

void Create(const client::Client& client, const std::string& id) {
  v1::CreateDatabaseRequest request;
  request.set_database_id(id);
  request.mutable_database()->set_marker_set("source");
  Required(client.CreateDatabase(request));
}

v1::IngestClipResponse IngestFigure(const client::Client& client, const std::string& parent,
                                    const StickFigure& figure, int number) {
  v1::IngestClipHeader header;
  header.set_parent(parent);
  header.set_file_name(fmt::format("figure{}.bvh", number));
  header.set_label(figure.act == Act::kWalk ? "walk" : figure.act == Act::kWave ? "wave" : "squat");
  return Required(client.IngestBytes(header, WriteBvh(figure)));
}

void MakeDatabase(const client::Client& client, const Options& options) {
  constexpr Act kActs[] = {Act::kWalk, Act::kSquat, Act::kWave};
  Create(client, options.database);
  const int clip_frames = std::clamp(options.frames / 12, 60, 10'000);
  std::string operation;
  for (int number = 0; number * clip_frames < options.frames; ++number) {
    const StickFigure figure{.act = kActs[number % 3],
                             .frame_count = clip_frames,
                             .phase = 0.1 * number,
                             .tempo = 0.8 + 0.01 * (number % 40)};
    operation =
        IngestFigure(client, "databases/" + options.database, figure, number).operation().name();
  }
  const v1::Operation built =
      Required(client.WaitOperation(operation, {}, {std::chrono::hours(1)}));
  if (built.state() != v1::OPERATION_STATE_SUCCEEDED) {
    throw std::runtime_error(built.ShortDebugString());
  }
}

// The sink has the markers of the figures.
ExtremeSubject FindSubject(const client::Client& client, const Options& options) {
  ExtremeSubject subject{.database = "databases/" + options.database, .sink = "databases/sink"};
  v1::ListClipsRequest clips;
  clips.set_parent(subject.database);
  subject.clip = Required(client.AllClips(clips)).at(0).name();
  v1::ExportClipRequest stored;
  stored.set_name(subject.clip);
  subject.clip_bytes = std::ssize(Required(client.ExportClip(stored)).file);
  v1::GetDatabaseRequest describe;
  describe.set_name(subject.database);
  subject.marker_count = Required(client.GetDatabase(describe)).database().marker_names_size();
  Create(client, "sink");
  Required(client.WaitOperation(
      IngestFigure(client, subject.sink, {.frame_count = 120}, 0).operation().name()));
  return subject;
}

// Deletes the clips and waits until no build runs.
void EmptySink(const client::Client& client, const std::string& sink) {
  v1::ListClipsRequest request;
  request.set_parent(sink);
  std::string operation;
  for (const v1::Clip& clip : Required(client.AllClips(request))) {
    if (clip.file_name() == "figure0.bvh") continue;
    v1::DeleteClipRequest gone;
    gone.set_name(clip.name());
    operation = Required(client.DeleteClip(gone)).operation().name();
  }
  if (!operation.empty()) Required(client.WaitOperation(operation));
}

struct Measured {
  std::string kind;
  int number = 0;
  std::int64_t size = 0;
  std::int64_t peak = 0;
  double seconds = 0;
  absl::Status status;

  double share() const {
    return static_cast<double>(peak) / static_cast<double>(kMaxOfAnyCall + kTimesItsSize * size);
  }
};

void Report(std::vector<Measured> calls) {
  std::map<std::string, int> codes;
  for (const Measured& call : calls) ++codes[absl::StatusCodeToString(call.status.code())];
  for (const auto& [code, count] : codes) fmt::print("{:<24}{:>8}\n", code, count);
  std::sort(calls.begin(), calls.end(),
            [](const Measured& a, const Measured& b) { return a.share() > b.share(); });
  fmt::print("\n{:<34}{:>7}{:>10}{:>10}{:>9}{:>7}  {}\n", "worst", "call", "size MB", "peak MB",
             "of limit", "s", "status");
  for (std::size_t i = 0; i < std::min<std::size_t>(15, calls.size()); ++i) {
    const Measured& call = calls[i];
    fmt::print("{:<34}{:>7}{:>10.3f}{:>10.1f}{:>8.0f}%{:>7.2f}  {}\n", call.kind, call.number,
               static_cast<double>(call.size) / 1e6, static_cast<double>(call.peak) / 1e6,
               100 * call.share(), call.seconds,
               std::string(call.status.ToString()).substr(0, 150));
  }
}

std::vector<Measured> RunInTurn(const Options& options, const Served& served,
                                const ExtremeSubject& subject) {
  const client::Client client = served.Connect();
  std::vector<Measured> calls;
  for (int i = 0; i < options.calls; ++i) {
    std::mt19937 random(options.seed + static_cast<unsigned>(i));
    const ExtremeCall call =
        MakeExtremeCall(random, subject, static_cast<std::size_t>(options.largest_kib) << 10);
    ForgetPeak(served.pid());
    const std::int64_t before = ResidentMemory(served.pid());
    const auto begin = std::chrono::steady_clock::now();
    Measured& measured = calls.emplace_back();
    measured.status = call.send(client);
    measured.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    measured.peak = PeakMemory(served.pid()) - before;
    measured.kind = call.kind;
    measured.number = i;
    measured.size = call.size;
    if (call.kind.starts_with("Ingest") && measured.status.ok()) EmptySink(client, subject.sink);
  }
  return calls;
}

std::vector<Measured> RunTogether(const Options& options, const Served& served,
                                  const ExtremeSubject& subject) {
  std::mutex mutex;
  std::vector<Measured> calls;
  std::atomic<int> next = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < options.concurrency; ++t) {
    threads.emplace_back([&] {
      const auto client = client::Client::Connect({.server = served.address()});
      for (int i = next++; i < options.calls && client.ok(); i = next++) {
        std::mt19937 random(options.seed + static_cast<unsigned>(i));
        const ExtremeCall call =
            MakeExtremeCall(random, subject, static_cast<std::size_t>(options.largest_kib) << 10);
        Measured measured{.kind = call.kind, .number = i, .size = call.size};
        measured.status = call.send(*client);
        const std::lock_guard lock(mutex);
        calls.push_back(std::move(measured));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  return calls;
}

int Run(const Options& options) {
  std::optional<MemoryCgroup> cgroup;
  if (options.cgroup_mib > 0) {
    if (!kMemoryCounts) {
      fmt::print("skipped: a sanitizer needs more memory than the server's limit\n");
      return kSkipped;
    }
    try {
      cgroup.emplace(std::int64_t{options.cgroup_mib} << 20);
    } catch (const std::exception& error) {
      fmt::print("skipped: {}\n", error.what());
      return kSkipped;
    }
  }
  const TemporaryDirectory directory;
  const std::string store = options.store.empty() ? directory / "extreme.db" : options.store;
  auto served = std::make_unique<Served>(options, store);
  if (cgroup) cgroup->Add(served->pid());
  ExtremeSubject subject;
  {
    const client::Client client = served->Connect();
    if (options.store.empty()) MakeDatabase(client, options);
    subject = FindSubject(client, options);
  }
  std::vector<std::string> problems;
  ForgetPeak(served->pid());
  const std::int64_t idle = ResidentMemory(served->pid());
  const bool in_turn = options.concurrency == 1;
  std::vector<Measured> calls;
  try {
    calls = in_turn ? RunInTurn(options, *served, subject) : RunTogether(options, *served, subject);
    const std::int64_t peak = in_turn ? 0 : PeakMemory(served->pid());
    if (!in_turn) {
      fmt::print("idle {:.0f} MB, peak {:.0f} MB", static_cast<double>(idle) / 1e6,
                 static_cast<double>(peak) / 1e6);
      if (cgroup) {
        fmt::print(", cgroup with files {:.0f} of {:.0f} MB",
                   static_cast<double>(cgroup->peak()) / 1e6, options.cgroup_mib * 1.048576);
      }
      fmt::print("\n");
    }
    const int code = served->Stop();
    if (code != 0) problems.push_back(fmt::format("the server exited with {}", code));
  } catch (const std::exception& error) {
    problems.push_back(fmt::format("the server did not survive: {}", error.what()));
  }
  served.reset();
  Report(calls);
  for (const Measured& call : calls) {
    if (in_turn && kMemoryCounts && call.share() > 1) {
      problems.push_back(fmt::format("call {} ({}) used {:.0f} MB for a size of {:.3f} MB",
                                     call.number, call.kind, static_cast<double>(call.peak) / 1e6,
                                     static_cast<double>(call.size) / 1e6));
    }
    if (absl::IsInternal(call.status) || absl::IsUnknown(call.status)) {
      problems.push_back(
          fmt::format("call {} ({}): {}", call.number, call.kind, call.status.ToString()));
    }
  }
  for (const std::string& problem : problems) fmt::print("PROBLEM {}\n", problem);
  fmt::print("{} calls, {} problems\n", calls.size(), problems.size());
  return problems.empty() ? 0 : 1;
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) {
  motiondb::tests::Options options;
  CLI::App app("motiondb_extreme_calls: memory-intensive calls to a real server");
  app.add_option("--calls", options.calls, "Number of calls")->check(CLI::Range(1, 1'000'000));
  app.add_option("--seed", options.seed, "Seed of the first call; it increases by 1 per call");
  app.add_option("--concurrency", options.concurrency, "Concurrent calls; 1: measure each call")
      ->check(CLI::Range(1, 1024));
  app.add_option("--cgroup-mib", options.cgroup_mib, "Memory limit of the server; 0: no limit");
  app.add_option("--frames", options.frames, "Frames of the generated database");
  app.add_option("--largest-kib", options.largest_kib, "Size of the largest call");
  app.add_option("--store", options.store, "Use this store; a database `sink` is added to it");
  app.add_option("--database", options.database, "Id of the database in that store");
  app.add_option("--server", options.server, "The motiondbd program");
  app.add_option("--server-option", options.server_options, "Additional argument of motiondbd");
  CLI11_PARSE(app, argc, argv);
  try {
    return motiondb::tests::Run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "motiondb_extreme_calls: {}\n", error.what());
    return 1;
  }
}
