// Compares the HTTP API with gRPC: the same recognitions over Connect with protobuf, over Connect
// with JSON, and over gRPC, alternately. Server and clients are one process. Wall time.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "tests/bench/bench_program.h"
#include "tests/bench/client_load.h"
#include "tests/bench/connect_client.h"
#include "tests/bench/served_motion.h"

namespace motiondb::tests {
namespace {

constexpr char kDatabase[] = "database1";
constexpr int kFrameRateHz = 60;
constexpr int kWindowFrames = 24;
constexpr int kWarmUp = 8;

using Clients = std::vector<std::unique_ptr<LoadClient>>;
enum Way { kGrpc, kProtobuf, kJson, kWays };

absl::StatusOr<std::vector<v1::RecognizeRequest>> Questions(ServedMotion& served) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto clips, ReadClips("database1.test"));
  std::vector<v1::RecognizeRequest> requests;
  for (const MotionBytes& clip : clips) {
    MOTIONDB_ASSIGN_OR_RETURN(const v1::MarkerObservation markers,
                              served.Represent(kDatabase, clip, kFrameRateHz));
    for (int f = 0; f + kWindowFrames <= markers.frame_count(); f += kWindowFrames) {
      v1::RecognizeRequest& request = requests.emplace_back();
      request.set_database(fmt::format("databases/{}", kDatabase));
      *request.mutable_observation()->mutable_markers() = Cut(markers, f, kWindowFrames);
      request.set_top_count(5);
    }
  }
  return requests;
}

std::string Costs(const Load& load) {
  return fmt::format("processor time per answer {:.3f} ms, p50 {:.2f} ms, p99 {:.2f} ms",
                     load.processor_ms(), load.LatencyQuantile(0.5), load.LatencyQuantile(0.99));
}

// Adds a row for each way over HTTP.
absl::Status Compare(ServedMotion& served, const std::vector<v1::RecognizeRequest>& requests,
                     int count, int rounds, Seconds round, BenchTable& table) {
  std::array<Clients, kWays> clients;
  for (int c = 0; c < count; ++c) {
    const std::size_t first = 7 * static_cast<std::size_t>(c);
    const std::string web = served.web_address();
    clients[kGrpc].push_back(NewRecognizeClient(served.address(), requests, first));
    clients[kProtobuf].push_back(NewConnectClient(web, ConnectCodec::kProtobuf, requests, first));
    clients[kJson].push_back(NewConnectClient(web, ConnectCodec::kJson, requests, first));
  }
  // The ways must give the same answer.
  std::array<std::string, kWays> answers;
  for (int way = 0; way < kWays; ++way) {
    MOTIONDB_RETURN_IF_ERROR(clients[way].front()->Ask());
    answers[way] = clients[way].front()->Reply();
    if (answers[way] != answers[kGrpc]) {
      return absl::InternalError("the answers over gRPC and HTTP differ");
    }
  }
  std::array<Load, kWays> loads;
  for (int i = 0; i < rounds; ++i) {
    for (int way = 0; way < kWays; ++way) {
      MOTIONDB_ASSIGN_OR_RETURN(const Load load, RunConcurrently(clients[way], kWarmUp, round));
      loads[way].Add(load);
    }
  }
  for (const auto& [way, name] : {std::pair{kProtobuf, "protobuf"}, std::pair{kJson, "JSON"}}) {
    BenchRow row = RatioRow(
        fmt::format("recognize over Connect, {}, {} client{}", name, count, count > 1 ? "s" : ""),
        loads[way].rate(), "gRPC, same requests", loads[kGrpc].rate(), "calls/s", NoBar());
    row.note = fmt::format("{} (gRPC: {})", Costs(loads[way]), Costs(loads[kGrpc]));
    table.rows.push_back(std::move(row));
  }
  return absl::OkStatus();
}

absl::StatusOr<BenchTable> Measure(bool quick) {
  const int rounds = quick ? 1 : 5;
  const Seconds round(quick ? 0.5 : 2);
  MOTIONDB_ASSIGN_OR_RETURN(const auto train, ReadClips("database1.train"));
  MOTIONDB_ASSIGN_OR_RETURN(const auto served, ServedMotion::Start());
  MOTIONDB_RETURN_IF_ERROR(served->Create(kDatabase));
  MOTIONDB_RETURN_IF_ERROR(served->Fill(kDatabase, train));
  MOTIONDB_ASSIGN_OR_RETURN(const auto requests, Questions(*served));
  BenchTable table{"gateway", {}, {}};
  for (const int count : {1, 32}) {
    MOTIONDB_RETURN_IF_ERROR(Compare(*served, requests, count, rounds, round, table));
  }
  table.notes.push_back(fmt::format(
      "gateway: windows of 0.4 s ({} bytes as protobuf) in the {} clips of database 1, {} rounds "
      "of {:g} s for each way, alternately; every client has its own thread and connection, "
      "serializes its request and parses its answer",
      requests.front().ByteSizeLong(), train.size(), rounds, round.count()));
  return table;
}

int Main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::warn);
  BenchProgram program("Compares the HTTP API with gRPC.", "motiondb_bench_gateway");
  bool quick = false;
  program.app().add_flag("--quick", quick, "One short round");
  return program.Run(argc, argv, [&] { return Measure(quick); });
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) { return motiondb::tests::Main(argc, argv); }
