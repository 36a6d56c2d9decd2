// Runs many clients, good and bad, on a real motiondbd for a long time. Memory, descriptors and log
// must stay bounded; calls fail only by their client's fault; the server logs no error of its own.
// Acknowledged clips must exist at the end and after a restart, and the model must contain them.
//   motiondb_soak [--seconds 1200] [--json FILE]
#include <fmt/format.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.pb.h"
#include "tests/soak/good_clients.h"
#include "tests/soak/process_statistics.h"
#include "tests/support/child_process.h"
#include "tests/support/project_paths.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {
namespace {

using Clock = std::chrono::steady_clock;

// Limits for a small database with these clients. A leak of a descriptor or a page per call would
// exceed them within minutes.
constexpr int kMaxDescriptors = 200;
constexpr int kMaxThreads = 64;
#ifdef __SANITIZE_ADDRESS__  // keeps freed memory for a while, and shadow memory
constexpr double kMaxMemoryMb = 2048;
#else
constexpr double kMaxMemoryMb = 512;
#endif
constexpr double kMaxLogMb = 64;
// Last third of the run against the second: a leak grows there too.
constexpr double kMaxGrowth = 1.25;
constexpr double kSlackMb = 32;

class Served {
 public:
  Served(const std::string& store, const std::string& log)
      : process_({MotiondbdProgram(), "--store", store, "--listen", "127.0.0.1:0", "--log-level",
                  "error", "--rebuild-delay", "0.3", "--grace-seconds", "10"},
                 log) {
    constexpr std::string_view kAnnouncement = "motiondbd: listening on ";
    while (address_.empty()) {
      const std::string line = process_.ReadLine();
      if (line.empty()) throw std::runtime_error("motiondbd did not start");
      if (line.starts_with(kAnnouncement)) address_ = line.substr(kAnnouncement.size());
    }
  }
  const std::string& address() const { return address_; }
  pid_t pid() const { return process_.pid(); }
  // Returns the exit code.
  int Stop() {
    process_.Signal(SIGTERM);
    return process_.Wait();
  }

 private:
  ChildProcess process_;
  std::string address_;
};

// Returns the maximum of each field in each third of the run.
std::vector<ProcessStatistics> Observe(const Served& served, const std::string& store,
                                       double seconds) {
  std::vector<ProcessStatistics> thirds(3);
  const auto begin = Clock::now();
  while (true) {
    const double passed = std::chrono::duration<double>(Clock::now() - begin).count();
    if (passed >= seconds) return thirds;
    auto& third = thirds[static_cast<std::size_t>(3 * passed / seconds)];
    third = Largest(third, ReadProcessStatistics(served.pid(), store));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
}

// Returns the acknowledged clips that do not exist.
std::vector<std::string> Missing(Soak& soak) {
  v1::ListClipsRequest request;
  request.set_parent("databases/soak");
  const auto clips = Connect(soak).AllClips(request);
  if (!clips.ok()) throw std::runtime_error(clips.status().ToString());
  std::set<std::string> there;
  for (const v1::Clip& clip : *clips) there.insert(clip.name());
  std::vector<std::string> missing;
  for (const std::string& clip : soak.clips) {
    if (!there.contains(clip)) missing.push_back(clip);
  }
  return missing;
}

// Returns whether the model comes to contain exactly the remaining clips after the last change.
bool CatchesUp(Soak& soak) {
  const client::Client client = Connect(soak);
  v1::GetDatabaseRequest request;
  request.set_view(v1::DATABASE_VIEW_FULL);
  request.set_name("databases/soak");
  const auto end = Clock::now() + std::chrono::seconds(120);
  while (Clock::now() < end) {
    const auto described = client.GetDatabase(request);
    if (!described.ok()) throw std::runtime_error(described.status().ToString());
    const v1::DatabaseStatistics& statistics = described->database().statistics();
    if (statistics.clip_count() == statistics.stored_clip_count()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  return false;
}

// Returns the first errors that the server logged as its own, and their number.
std::vector<std::string> LoggedErrors(const std::string& log) {
  constexpr std::size_t kShown = 5;
  std::ifstream file(log);
  std::vector<std::string> errors;
  std::size_t count = 0;
  for (std::string line; std::getline(file, line); ++count) {
    if (errors.size() < kShown) errors.push_back("logged: " + line);
  }
  if (count > kShown) errors.push_back(fmt::format("logged: {} lines in total", count));
  return errors;
}

void Check(bool good, const std::string& what, std::vector<std::string>& problems) {
  if (!good) problems.push_back(what);
}

std::vector<std::string> Judge(const std::vector<ProcessStatistics>& thirds, const Tally& tally) {
  std::vector<std::string> problems = tally.faults();
  const ProcessStatistics& before = thirds[1];
  const ProcessStatistics& last = thirds[2];
  Check(last.memory_mb <= kMaxGrowth * before.memory_mb + kSlackMb,
        fmt::format("memory grew from {:.0f} to {:.0f} MB", before.memory_mb, last.memory_mb),
        problems);
  for (const ProcessStatistics& figures : thirds) {
    Check(figures.descriptors <= kMaxDescriptors,
          fmt::format("{} descriptors were open", figures.descriptors), problems);
    Check(figures.threads <= kMaxThreads, fmt::format("{} threads", figures.threads), problems);
    Check(figures.memory_mb <= kMaxMemoryMb, fmt::format("memory was {:.0f} MB", figures.memory_mb),
          problems);
    Check(figures.log_mb <= kMaxLogMb, fmt::format("the log was {:.0f} MB", figures.log_mb),
          problems);
  }
  return problems;
}

void Report(const std::vector<ProcessStatistics>& thirds, const Tally& tally,
            const std::vector<std::string>& problems, const std::string& file) {
  fmt::print("{:<12}{:>12}{:>14}{:>10}{:>12}{:>10}\n", "third", "memory MB", "descriptors",
             "threads", "store MB", "log MB");
  nlohmann::ordered_json json;
  for (std::size_t i = 0; i < thirds.size(); ++i) {
    const ProcessStatistics& f = thirds[i];
    fmt::print("{:<12}{:>12.0f}{:>14}{:>10}{:>12.1f}{:>10.1f}\n", i + 1, f.memory_mb, f.descriptors,
               f.threads, f.store_mb, f.log_mb);
    json["thirds"].push_back({{"memory_mb", f.memory_mb},
                              {"descriptors", f.descriptors},
                              {"threads", f.threads},
                              {"store_mb", f.store_mb},
                              {"log_mb", f.log_mb}});
  }
  fmt::print("\n");
  for (const auto& [call, count] : tally.counts()) {
    fmt::print("{:<48}{:>10}\n", call, count);
    json["calls"][call] = count;
  }
  json["problems"] = problems;
  for (const std::string& problem : problems) fmt::print("PROBLEM {}\n", problem);
  if (!file.empty()) std::ofstream(file) << json.dump(2) << "\n";
}

int Run(double seconds, const std::string& json_file) {
  const TemporaryDirectory directory;
  const std::string store = directory / "soak.db";
  const std::string log = directory / "errors.log";
  auto served = std::make_unique<Served>(store, log);
  Soak soak;
  soak.address = served->address();
  Prepare(soak);

  std::vector<std::thread> clients;
  const auto start = [&](std::function<void()> loop) {
    clients.emplace_back([&soak, loop = std::move(loop)] {
      try {
        loop();
      } catch (const std::exception& error) {
        soak.tally.Add("A client's loop", absl::InternalError(error.what()));
      }
    });
  };
  start([&] { IngestAndDelete(soak); });
  start([&] { Administer(soak); });
  for (unsigned seed = 1; seed <= 2; ++seed) start([&soak, seed] { SendAllQueries(soak, seed); });
  for (unsigned seed = 1; seed <= 4; ++seed) start([&soak, seed] { Watch(soak, seed); });
  for (unsigned seed = 1; seed <= 2; ++seed) start([&soak, seed] { Misbehave(soak, seed); });
  const auto thirds = Observe(*served, store, seconds);
  soak.over = true;
  for (std::thread& client : clients) client.join();

  std::vector<std::string> problems = Judge(thirds, soak.tally);
  Check(Missing(soak).empty(), "acknowledged clips are missing", problems);
  Check(CatchesUp(soak), "the model does not match the stored clips", problems);
  Check(served->Stop() == 0, "the server did not exit with 0", problems);
  served = std::make_unique<Served>(store, log);
  soak.address = served->address();
  Check(Missing(soak).empty(), "acknowledged clips are missing after a restart", problems);
  Check(served->Stop() == 0, "the server did not exit with 0 after its restart", problems);
  const std::vector<std::string> logged = LoggedErrors(log);
  problems.insert(problems.end(), logged.begin(), logged.end());
  Report(thirds, soak.tally, problems, json_file);
  return problems.empty() ? 0 : 1;
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) {
  double seconds = 1200;
  std::string json;
  CLI::App app("motiondb_soak: runs many clients on a real server for a long time");
  app.add_option("--seconds", seconds, "Duration of the load")
      ->check(CLI::Range(3.0, 86400.0))
      ->capture_default_str();
  app.add_option("--json", json, "Also write the statistics to this file");
  CLI11_PARSE(app, argc, argv);
  try {
    return motiondb::tests::Run(seconds, json);
  } catch (const std::exception& error) {
    fmt::print(stderr, "motiondb_soak: {}\n", error.what());
    return 1;
  }
}
