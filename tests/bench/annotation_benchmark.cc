// Measures annotations through a server: filtered lists of 100,000 clips, and the time from a
// changed label to an answer that knows it, in a model of 1M frames. The peer is a call of the same
// connection that reads one object. Wall time of one client.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "motiondb/client.h"
#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/server.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/large_store.h"
#include "tests/bench/served_motion.h"
#include "tests/support/real_data.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/threads.h"

namespace motiondb::tests {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr int kRounds = 21;
constexpr int kRareClips = 10;
constexpr double kListBarMs = 50;
constexpr double kLabelBarSeconds = 1;
const std::string kParent = fmt::format("databases/{}", kLargeDatabase);

struct Options {
  VariedSize listed{.clips = 100'000, .frames = 800'000};
  VariedSize labelled;
  int jobs = 1;
};

struct Served {
  std::unique_ptr<server::Server> server;
  std::unique_ptr<client::Client> client;
};

absl::StatusOr<Served> Serve(const std::string& store_path) {
  Served served;
  MOTIONDB_ASSIGN_OR_RETURN(auto store, storage::SqliteMotionStore::Open(store_path));
  server::ServerOptions options;
  options.listen = "127.0.0.1:0";
  MOTIONDB_ASSIGN_OR_RETURN(served.server, server::Server::Start(std::move(store), options));
  MOTIONDB_ASSIGN_OR_RETURN(auto client,
                            client::Client::Connect({.server = served.server->address(),
                                                     .call_timeout = std::chrono::minutes(10)}));
  served.client = std::make_unique<client::Client>(std::move(client));
  return served;
}

// Returns the median time of a call, ms.
absl::StatusOr<double> MedianMs(const std::function<absl::Status()>& call) {
  std::vector<double> times;
  for (int round = 0; round < kRounds; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    MOTIONDB_RETURN_IF_ERROR(call());
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
            .count());
  }
  std::ranges::nth_element(times, times.begin() + kRounds / 2);
  return times[kRounds / 2];
}

absl::StatusOr<double> OneObjectMs(const client::Client& client) {
  return MedianMs([&] {
    v1::GetDatabaseRequest request;
    request.set_name(kParent);
    return client.GetDatabase(request).status();
  });
}

absl::Status ListRows(const Options& options, BenchTable& table) {
  const TemporaryDirectory directory;
  const std::string path = directory / "listed.db";
  MOTIONDB_ASSIGN_OR_RETURN(
      auto clips, VariedClips(DataDir(), options.listed, kSeed, RunOnThreads(options.jobs)));
  for (int i = 0; i < kRareClips; ++i) {
    clips[i * clips.size() / kRareClips].subject = "rare";
  }
  MOTIONDB_RETURN_IF_ERROR(MakeClipStore(path, options.listed.frame_rate_hz, std::move(clips)));
  MOTIONDB_RETURN_IF_ERROR(RebuildStore(path, RunOnThreads(options.jobs)).status());
  MOTIONDB_ASSIGN_OR_RETURN(const Served served, Serve(path));
  MOTIONDB_ASSIGN_OR_RETURN(const double one_object, OneObjectMs(*served.client));
  for (const auto& [filter, order] : std::vector<std::pair<std::string, std::string>>{
           {"subject = rare", ""},
           {"duration > 0s AND NOT label = none AND subject = rare", "duration desc"},
           {"subject = rare AND segment:(track = action)", "create_time"}}) {
    v1::ListClipsRequest request;
    request.set_parent(kParent);
    request.set_page_size(1000);
    request.set_filter(filter);
    request.set_order_by(order);
    MOTIONDB_ASSIGN_OR_RETURN(const double ms, MedianMs([&] {
                                const auto listed = served.client->ListClips(request);
                                MOTIONDB_RETURN_IF_ERROR(listed.status());
                                return listed->clips_size() == kRareClips
                                           ? absl::OkStatus()
                                           : core::InvalidArgument("{}: expected {} clips, got {}",
                                                                   filter, kRareClips,
                                                                   listed->clips_size());
                              }));
    BenchRow row = RatioRow(fmt::format("list {} clips, filter `{}`{}", options.listed.clips,
                                        filter, order.empty() ? "" : ", by " + order),
                            ms, "the bar", kListBarMs, "ms", AtMost(1));
    row.note = fmt::format("passes {} clips; GetDatabase on the same connection takes {:.2f} ms",
                           kRareClips, one_object);
    table.rows.push_back(std::move(row));
  }
  return absl::OkStatus();
}

// Changes the label of a clip and waits for an answer that contains the change.
absl::Status Relabel(const client::Client& client, const std::string& clip,
                     const std::string& label, v1::RecognizeRequest question) {
  v1::UpdateClipRequest update;
  update.mutable_clip()->set_name(clip);
  update.mutable_clip()->set_label(label);
  update.mutable_update_mask()->add_paths("label");
  MOTIONDB_ASSIGN_OR_RETURN(const auto updated, client.UpdateClip(update));
  question.set_min_revision(updated.revision());
  MOTIONDB_ASSIGN_OR_RETURN(const auto answer, client.Recognize(question));
  for (const v1::LabelProbability& each : answer.windows(0).labels()) {
    if (each.label() == label) return absl::OkStatus();
  }
  return absl::InternalError("the answer does not have the new label");
}

absl::Status LabelRow(const Options& options, BenchTable& table) {
  const TemporaryDirectory directory;
  const std::string path = directory / "labelled.db";
  MOTIONDB_RETURN_IF_ERROR(
      MakeLargeStore(path, options.labelled, kSeed, RunOnThreads(options.jobs)).status());
  MOTIONDB_ASSIGN_OR_RETURN(const Served served, Serve(path));
  v1::ListClipsRequest list;
  list.set_parent(kParent);
  MOTIONDB_ASSIGN_OR_RETURN(const auto listed, served.client->ListClips(list));
  const std::string clip = listed.clips(0).name();
  v1::RecognizeRequest question;
  question.set_database(kParent);
  MOTIONDB_ASSIGN_OR_RETURN(const auto recorded, ReadClips("database1.test"));
  v1::FileObservation& file = *question.mutable_observation()->mutable_file();
  file.set_file_name(recorded[0].header.file_name());
  file.set_data(recorded[0].file);
  file.set_skeleton_file_name(recorded[0].header.skeleton_file_name());
  file.set_skeleton_data(recorded[0].skeleton);
  question.set_whole(true);
  MOTIONDB_ASSIGN_OR_RETURN(const double unchanged,
                            MedianMs([&] { return served.client->Recognize(question).status(); }));
  int round = 0;
  MOTIONDB_ASSIGN_OR_RETURN(const double changed, MedianMs([&] {
                              ++round;
                              return Relabel(*served.client, clip, fmt::format("changed{}", round),
                                             question);
                            }));
  BenchRow row = RatioRow(fmt::format("new label in an answer, {} frames in {} clips",
                                      options.labelled.frames, options.labelled.clips),
                          changed / 1e3, "the bar", kLabelBarSeconds, "s", AtMost(1));
  row.note = fmt::format(
      "UpdateClip, then Recognize with min_revision; the same query without a change takes {:.2f} "
      "ms",
      unchanged);
  table.rows.push_back(std::move(row));
  return absl::OkStatus();
}

absl::StatusOr<BenchTable> Run(const Options& options) {
  BenchTable table{"annotations", {}, {}};
  MOTIONDB_RETURN_IF_ERROR(ListRows(options, table));
  MOTIONDB_RETURN_IF_ERROR(LabelRow(options, table));
  table.notes.push_back(fmt::format("annotations: {}", kVariedMotion));
  return table;
}

int Main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::warn);
  BenchProgram program("Measures lists and labels through a server.", "motiondb_bench_annotations");
  Options options;
  program.AddSize(options.labelled);
  program.AddJobs(options.jobs, "Threads that generate and build");
  program.app()
      .add_option("--listed", options.listed.clips, "Clips of the lists")
      ->check(CLI::Range(kRareClips, 1'000'000))
      ->capture_default_str();
  return program.Run(argc, argv, [&] {
    options.listed.frames = 8 * options.listed.clips;
    return Run(options);
  });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
