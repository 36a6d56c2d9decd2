// Measures a server whose clients run on the same machine: queries and streams compared with a gRPC
// server that answers the same bytes immediately, ingestion compared with SQLite, and query latency
// during a rebuild. Server, peer and clients are one process, so both sides pay for the same
// clients; they alternate. Wall time.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"
#include "storage/sqlite/store_file.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/client_load.h"
#include "tests/bench/empty_peer.h"
#include "tests/bench/served_motion.h"
#include "tests/support/real_data.h"

namespace motiondb::tests {
namespace {
using Clock = std::chrono::steady_clock;

constexpr char kDatabase[] = "database1";
constexpr int kFrameRateHz = 60;
constexpr int kWindowFrames = 24;
constexpr int kRecognizeClients = 32;
constexpr int kStreams = 100;
constexpr int kFramesAMessage = 4;
// Fills the window of every stream.
constexpr int kWarmUp = kWindowFrames / kFramesAMessage + 2;
constexpr int kIngestStreams = 4;
constexpr Seconds kQuestionPeriod{0.005};
// Slightly more than the idle time before a build.
constexpr Seconds kIngestPeriod{0.4};

struct Options {
  bool quick = false;
  std::string only;  // one measurement; empty: all

  int rounds() const { return quick ? 1 : 5; }
  Seconds round() const { return Seconds(quick ? 0.5 : 2); }
};

struct Bench {
  Options options;
  std::vector<MotionBytes> train, test;
  std::unique_ptr<ServedMotion> served;
  std::vector<v1::MarkerObservation> observed;  // the test clips
  BenchTable table{"server", {}, {}};
};

using Clients = std::vector<std::unique_ptr<LoadClient>>;

// Makes client number c of a server.
using NewClient =
    std::function<std::unique_ptr<LoadClient>(const std::string& address, bool peer, int c)>;

Clients Make(const NewClient& make, int count, const std::string& address, bool peer) {
  Clients clients;
  for (int c = 0; c < count; ++c) clients.push_back(make(address, peer, c));
  return clients;
}

// Returns the answer of median size.
absl::StatusOr<std::string> TypicalReply(LoadClient& client) {
  std::vector<std::string> replies;
  for (int i = 0; i < 10 * kWarmUp; ++i) {
    MOTIONDB_RETURN_IF_ERROR(client.Ask());
    if (i >= kWarmUp) replies.push_back(client.Reply());
  }
  const auto middle = replies.begin() + static_cast<std::ptrdiff_t>(replies.size() / 2);
  std::nth_element(replies.begin(), middle, replies.end(),
                   [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return *middle;
}

struct Sides {
  Load ours, theirs;
  std::size_t reply_bytes = 0;
};

// Runs the same `count` clients on the server and on an empty peer, alternately.
absl::StatusOr<Sides> BesidePeer(const Bench& bench, const std::string& method,
                                 EmptyPeer::Shape shape, int count, const NewClient& make) {
  const std::string& address = bench.served->address();
  MOTIONDB_ASSIGN_OR_RETURN(const std::string reply, TypicalReply(*make(address, false, 0)));
  MOTIONDB_ASSIGN_OR_RETURN(const auto peer, EmptyPeer::Start({{method, {shape, reply}}}));
  const Clients on_ours = Make(make, count, address, false);
  const Clients on_theirs = Make(make, count, peer->address(), true);
  Sides sides{{}, {}, reply.size()};
  for (int round = 0; round < bench.options.rounds(); ++round) {
    MOTIONDB_ASSIGN_OR_RETURN(const Load ours,
                              RunConcurrently(on_ours, kWarmUp, bench.options.round()));
    MOTIONDB_ASSIGN_OR_RETURN(const Load theirs,
                              RunConcurrently(on_theirs, kWarmUp, bench.options.round()));
    sides.ours.Add(ours);
    sides.theirs.Add(theirs);
  }
  return sides;
}

// "processor time per answer 1 ms, p50 1 ms, p99 2 ms (peer 1 ms, 1 ms, 2 ms)"
std::string Costs(const Sides& sides) {
  return fmt::format(
      "processor time per answer {:.3f} ms, p50 {:.2f} ms, p99 {:.2f} ms (peer {:.3f} ms, {:.2f} "
      "ms, {:.2f} ms)",
      sides.ours.processor_ms(), sides.ours.LatencyQuantile(0.5), sides.ours.LatencyQuantile(0.99),
      sides.theirs.processor_ms(), sides.theirs.LatencyQuantile(0.5),
      sides.theirs.LatencyQuantile(0.99));
}

std::vector<v1::RecognizeRequest> Questions(const Bench& bench, v1::Method method) {
  std::vector<v1::RecognizeRequest> requests;
  for (const v1::MarkerObservation& clip : bench.observed) {
    for (int f = 0; f + kWindowFrames <= clip.frame_count(); f += kWindowFrames) {
      v1::RecognizeRequest& request = requests.emplace_back();
      request.set_database(fmt::format("databases/{}", kDatabase));
      *request.mutable_observation()->mutable_markers() = Cut(clip, f, kWindowFrames);
      request.set_top_count(5);
      request.set_method(method);
    }
  }
  return requests;
}

absl::Status RecognizeRow(Bench& bench, v1::Method method, Bar bar) {
  const auto requests = Questions(bench, method);
  const NewClient make = [&](const std::string& address, bool, int c) {
    return NewRecognizeClient(address, requests, 7 * static_cast<std::size_t>(c));
  };
  MOTIONDB_ASSIGN_OR_RETURN(const Sides sides,
                            BesidePeer(bench, "/motiondb.v1.QueryService/Recognize",
                                       EmptyPeer::Shape::kUnary, kRecognizeClients, make));
  BenchRow row =
      RatioRow(fmt::format("recognize over gRPC, {} clients{}", kRecognizeClients,
                           method == v1::METHOD_PAPER ? ", PAPER" : ""),
               sides.ours.rate(), "empty handler, same sizes", sides.theirs.rate(), "calls/s", bar);
  row.note = fmt::format(
      "one window of 0.4 s per call ({} bytes), answer with 5 clips and all labels ({} bytes); {}",
      requests.front().ByteSizeLong(), sides.reply_bytes, Costs(sides));
  bench.table.rows.push_back(std::move(row));
  return absl::OkStatus();
}

v1::ObserveRequest StreamStart(const std::vector<double>& horizons_s) {
  v1::ObserveRequest request;
  v1::ObserveStart& start = *request.mutable_start();
  start.set_database(fmt::format("databases/{}", kDatabase));
  start.set_frame_rate_hz(kFrameRateHz);
  for (const double seconds : horizons_s) start.add_horizon_seconds(seconds);
  return request;
}

std::vector<v1::ObserveRequest> Messages(const v1::MarkerObservation& clip) {
  std::vector<v1::ObserveRequest> messages;
  for (int f = 0; f + kFramesAMessage <= clip.frame_count(); f += kFramesAMessage) {
    v1::ObservedFrames& frames = *messages.emplace_back().mutable_frames();
    frames.set_frame_count(kFramesAMessage);
    frames.set_positions(Cut(clip, f, kFramesAMessage).positions());
  }
  return messages;
}

absl::Status ObserveRows(Bench& bench, const std::vector<double>& horizons_s, Bar rate_bar,
                         Bar late_bar) {
  const v1::ObserveRequest start = StreamStart(horizons_s);
  const NewClient make = [&](const std::string& address, bool peer, int c) {
    return NewObserveClient(address, peer ? nullptr : &start,
                            Messages(bench.observed[c % bench.observed.size()]));
  };
  MOTIONDB_ASSIGN_OR_RETURN(const Sides sides,
                            BesidePeer(bench, "/motiondb.v1.ObserveService/Observe",
                                       EmptyPeer::Shape::kStream, kStreams, make));
  const std::string name =
      fmt::format("observe, 204 floats a frame, {} frames a message, {} streams{}", kFramesAMessage,
                  kStreams, horizons_s.empty() ? "" : ", one horizon");
  BenchRow rate = RatioRow(name, sides.ours.rate(), "echo stream, same messages",
                           sides.theirs.rate(), "messages/s", rate_bar);
  rate.note =
      fmt::format("answers of {} bytes; {}; at {} frames per second this equals {:.0f} streams",
                  sides.reply_bytes, Costs(sides), kFrameRateHz,
                  sides.ours.rate() * kFramesAMessage / kFrameRateHz);
  bench.table.rows.push_back(std::move(rate));
  bench.table.rows.push_back(RatioRow(name + ", p99", sides.ours.LatencyQuantile(0.99),
                                      "echo stream, same messages",
                                      sides.theirs.LatencyQuantile(0.99), "ms", late_bar));
  return absl::OkStatus();
}

std::span<const std::byte> Bytes(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

// Inserts the raw bytes of each clip, each durable before the next.
absl::Status InsertRaw(storage::Connection& connection, const std::vector<MotionBytes>& clips) {
  for (const MotionBytes& clip : clips) {
    MOTIONDB_ASSIGN_OR_RETURN(
        auto transaction,
        storage::Transaction::Begin(connection, storage::Transaction::Kind::kWrite));
    MOTIONDB_RETURN_IF_ERROR(connection
                                 .Query("INSERT INTO raw (file, skeleton) VALUES (?, ?)",
                                        Bytes(clip.file), Bytes(clip.skeleton))
                                 .Run());
    MOTIONDB_RETURN_IF_ERROR(transaction.Commit());
  }
  return absl::OkStatus();
}

absl::StatusOr<double> TimeOf(const std::function<absl::Status()>& work) {
  const auto begin = Clock::now();
  MOTIONDB_RETURN_IF_ERROR(work());
  return Seconds(Clock::now() - begin).count();
}

// Ingests the clips, `streams` concurrently. Returns the seconds until all are acknowledged. Their
// model is then built before the peer runs.
absl::StatusOr<double> IngestAll(ServedMotion& served, const std::string& database,
                                 const std::vector<MotionBytes>& clips, int streams) {
  std::vector<absl::StatusOr<v1::IngestClipResponse>> ingested(clips.size());
  std::atomic<std::size_t> next = 0;
  const auto begin = Clock::now();
  std::vector<std::thread> threads;
  for (int s = 0; s < streams; ++s) {
    threads.emplace_back([&] {
      for (std::size_t i = next++; i < clips.size(); i = next++) {
        ingested[i] = served.Ingest(database, clips[i]);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const Seconds seconds = Clock::now() - begin;
  for (const auto& response : ingested) {
    MOTIONDB_RETURN_IF_ERROR(response.status());
    MOTIONDB_RETURN_IF_ERROR(served.Await(response->operation().name()));
  }
  return seconds.count();
}

absl::Status IngestRow(Bench& bench, int streams, Bar bar) {
  std::vector<MotionBytes> clips = bench.train;
  clips.insert(clips.end(), bench.test.begin(), bench.test.end());
  double megabytes = 0;
  for (const MotionBytes& clip : clips) megabytes += static_cast<double>(clip.size()) / 1e6;
  const std::string name = fmt::format("ingest{}", streams);
  MOTIONDB_ASSIGN_OR_RETURN(const auto raw,
                            storage::OpenWriter(bench.served->File(name + ".db"), ""));
  MOTIONDB_RETURN_IF_ERROR(
      raw->Execute("CREATE TABLE raw (key INTEGER PRIMARY KEY, file BLOB, skeleton BLOB) STRICT"));
  double ours = 0, theirs = 0;
  for (int round = 0; round < bench.options.rounds(); ++round) {
    const std::string database = fmt::format("{}-{}", name, round);
    MOTIONDB_RETURN_IF_ERROR(bench.served->Create(database));
    MOTIONDB_ASSIGN_OR_RETURN(const double ingested,
                              IngestAll(*bench.served, database, clips, streams));
    MOTIONDB_ASSIGN_OR_RETURN(const double inserted,
                              TimeOf([&] { return InsertRaw(*raw, clips); }));
    ours += ingested;
    theirs += inserted;
  }
  megabytes *= bench.options.rounds();
  BenchRow row =
      RatioRow(streams == 1 ? "ingest to acknowledged"
                            : fmt::format("ingest to acknowledged, {} clips at a time", streams),
               megabytes / ours, "the same bytes inserted raw into SQLite, same settings",
               megabytes / theirs, "MB/s", bar);
  row.note = fmt::format(
      "{} clips, each a motion file and a skeleton file, over one connection; parsed, mapped to "
      "the markers, stored as sent and as states, and synced before acknowledgement; the peer "
      "inserts serially, one transaction per clip; {:.1f} ms per clip (peer {:.1f} ms)",
      clips.size(), 1e3 * ours / static_cast<double>(clips.size() * bench.options.rounds()),
      1e3 * theirs / static_cast<double>(clips.size() * bench.options.rounds()));
  bench.table.rows.push_back(std::move(row));
  return absl::OkStatus();
}

// Ingests the clips, one per period, and waits for the model that contains the last.
absl::Status IngestSlowly(ServedMotion& served, std::span<const MotionBytes> clips) {
  v1::IngestClipResponse last;
  const auto begin = Clock::now();
  for (std::size_t i = 0; i < clips.size(); ++i) {
    std::this_thread::sleep_until(begin + std::chrono::duration_cast<Clock::duration>(
                                              static_cast<double>(i) * kIngestPeriod));
    MOTIONDB_ASSIGN_OR_RETURN(last, served.Ingest(kDatabase, clips[i]));
  }
  return served.Await(last.operation().name());
}

absl::Status RebuildRow(Bench& bench) {
  ServedMotion& served = *bench.served;
  const auto requests = Questions(bench, v1::METHOD_BEST);
  const auto client = NewRecognizeClient(served.address(), requests, 0);
  const auto clips = std::span(bench.test).first(bench.options.quick ? 6 : bench.test.size());
  const auto ask_for = [&](Seconds time) {
    const auto end = Clock::now() + time;
    return RunPeriodically(*client, kQuestionPeriod, [end] { return Clock::now() < end; });
  };
  MOTIONDB_RETURN_IF_ERROR(ask_for(Seconds(0.5)).status());
  // The database grows meanwhile: half of the idle time is measured before, half after.
  const Seconds half = static_cast<double>(clips.size()) * kIngestPeriod / 2;
  MOTIONDB_ASSIGN_OR_RETURN(Load idle, ask_for(half));
  MOTIONDB_ASSIGN_OR_RETURN(const int first, served.ModelVersion(kDatabase));
  absl::Status ingested;
  std::atomic<bool> built = false;
  std::thread ingester([&] {
    ingested = IngestSlowly(served, clips);
    built = true;
  });
  const auto busy = RunPeriodically(*client, kQuestionPeriod, [&] { return !built; });
  ingester.join();
  MOTIONDB_RETURN_IF_ERROR(ingested);
  MOTIONDB_RETURN_IF_ERROR(busy.status());
  MOTIONDB_ASSIGN_OR_RETURN(const int last, served.ModelVersion(kDatabase));
  MOTIONDB_ASSIGN_OR_RETURN(const Load after, ask_for(half));
  idle.Add(after);
  BenchRow row = RatioRow("query p99 during rebuild and ingest", busy->LatencyQuantile(0.99),
                          "idle p99", idle.LatencyQuantile(0.99), "ms", AtMost(1.5));
  row.note = fmt::format(
      "one client with a query every {:g} ms, latency from its scheduled time, for {:.1f} s in "
      "which {} clips are ingested, one every {:g} s, and {} models are built; p50 {:.2f} ms, "
      "maximum {:.1f} ms (idle {:.2f} ms, {:.1f} ms)",
      1e3 * kQuestionPeriod.count(), busy->seconds, clips.size(), kIngestPeriod.count(),
      last - first, busy->LatencyQuantile(0.5), busy->LatencyQuantile(1), idle.LatencyQuantile(0.5),
      idle.LatencyQuantile(1));
  bench.table.rows.push_back(std::move(row));
  return absl::OkStatus();
}

absl::Status SetUp(Bench& bench) {
  MOTIONDB_ASSIGN_OR_RETURN(bench.train, ReadClips("database1.train"));
  MOTIONDB_ASSIGN_OR_RETURN(bench.test, ReadClips("database1.test"));
  MOTIONDB_ASSIGN_OR_RETURN(bench.served, ServedMotion::Start());
  MOTIONDB_RETURN_IF_ERROR(bench.served->Create(kDatabase));
  MOTIONDB_RETURN_IF_ERROR(bench.served->Fill(kDatabase, bench.train));
  for (const MotionBytes& clip : bench.test) {
    MOTIONDB_ASSIGN_OR_RETURN(bench.observed.emplace_back(),
                              bench.served->Represent(kDatabase, clip, kFrameRateHz));
  }
  bench.table.notes.push_back(fmt::format(
      "server: the {} clips of database 1, queries from {} others, default options, {} hardware "
      "threads; server, peer and clients in one process, {} alternating rounds of {:g} s; every "
      "client has its own thread and connection, and sends the next request when it has its answer",
      bench.train.size(), bench.test.size(), std::thread::hardware_concurrency(),
      bench.options.rounds(), bench.options.round().count()));
  bench.table.notes.push_back(
      "observe: the 34 markers of a frame are 102 floats on the wire; the server computes the 204 "
      "floats of a state, positions and velocities, from them");
  return absl::OkStatus();
}

absl::StatusOr<BenchTable> Run(Bench& bench) {
  const std::pair<const char*, std::function<absl::Status()>> measurements[] = {
      {"recognize", [&] { return RecognizeRow(bench, v1::METHOD_BEST, AtLeast(0.5)); }},
      {"recognize-paper", [&] { return RecognizeRow(bench, v1::METHOD_PAPER, NoBar()); }},
      {"observe", [&] { return ObserveRows(bench, {}, AtLeast(0.5), AtMost(2)); }},
      {"observe-predict", [&] { return ObserveRows(bench, {0.4}, NoBar(), NoBar()); }},
      {"ingest",
       [&]() -> absl::Status {
         MOTIONDB_RETURN_IF_ERROR(IngestRow(bench, 1, AtLeast(0.5)));
         return IngestRow(bench, kIngestStreams, NoBar());
       }},
      {"rebuild", [&] { return RebuildRow(bench); }},  // last: it adds to the database
  };
  MOTIONDB_RETURN_IF_ERROR(SetUp(bench));
  for (const auto& [name, measure] : measurements) {
    const bool wanted = bench.options.only.empty() || bench.options.only == name;
    if (wanted) MOTIONDB_RETURN_IF_ERROR(measure());
  }
  return bench.table;
}

int Main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::warn);
  BenchProgram program("Measures a server under load.", "motiondb_bench_server");
  Bench bench;
  program.app().add_flag("--quick", bench.options.quick, "One short round per measurement");
  program.app()
      .add_option("--only", bench.options.only, "Run only this measurement")
      ->check(CLI::IsMember(
          {"recognize", "recognize-paper", "observe", "observe-predict", "ingest", "rebuild"}));
  return program.Run(argc, argv, [&] { return Run(bench); });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
