// A well-behaved client that measures a server under attack. It sends a health check every 50 ms
// and a Recognize of 0.4 s of motion every 100 ms, on time even if earlier calls are unanswered.
// Every second it also sends a health check on a new channel. It prints "ready", runs until its
// standard input ends, and prints one line of JSON. The line has for each kind of call: count,
// failures, p50, p99 and maximum in milliseconds, and the first error.
#include <fmt/format.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/channel_arguments.h>
#include <motiondb/client.h>
#include <motiondb/v1/observe.pb.h>
#include <motiondb/v1/query.grpc.pb.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <fstream>
#include <iterator>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/channel_credentials.h"

namespace motiondb::tests {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kHealthPeriod{50};
constexpr int kTicksPerRecognize = 2;
constexpr int kTicksPerConnect = 20;
constexpr milliseconds kTimeout{5000};
constexpr double kWindowSeconds = 0.4;

// Latencies of one kind of call. Thread-safe.
class Latencies {
 public:
  void Begin() {
    const std::lock_guard lock(mutex_);
    ++open_;
  }
  void End(Clock::time_point begin, const grpc::Status& status) {
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    const std::lock_guard lock(mutex_);
    ms_.push_back(ms);
    if (!status.ok() && ++failures_ == 1) {
      error_ =
          fmt::format("code {}: {}", static_cast<int>(status.error_code()), status.error_message());
    }
    if (--open_ == 0) none_open_.notify_all();
  }
  // Waits until no call is open. Every call has a deadline.
  nlohmann::json Summary() {
    std::unique_lock lock(mutex_);
    none_open_.wait(lock, [&] { return open_ == 0; });
    std::sort(ms_.begin(), ms_.end());
    return {{"count", ms_.size()},      {"failures", failures_}, {"p50_ms", Quantile(0.5)},
            {"p99_ms", Quantile(0.99)}, {"max_ms", Quantile(1)}, {"error", error_}};
  }

 private:
  double Quantile(double share) const {
    if (ms_.empty()) return 0;
    const double rank = std::ceil(share * static_cast<double>(ms_.size()));
    return ms_[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
  }

  std::mutex mutex_;
  std::condition_variable none_open_;
  int open_ = 0;
  int failures_ = 0;
  std::vector<double> ms_;
  std::string error_;
};

std::shared_ptr<grpc::Channel> NewChannel(const client::ClientOptions& options) {
  const auto credentials = client::CredentialsFor(options, {options.server});
  if (!credentials.ok()) throw std::runtime_error(credentials.status().ToString());
  grpc::ChannelArguments arguments;
  // A connection of its own, not the shared one of the address.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(options.server, *credentials, arguments);
}

// A running call with everything that must live until it ends. Its callback releases it before it
// counts it: gRPC 1.51 waits for its own thread forever, or frees twice, if one of its threads
// releases the last channel of the process.
template <typename Stub, typename Request, typename Response>
struct Call {
  Call(std::shared_ptr<Stub> its_stub, Request its_request)
      : stub(std::move(its_stub)), request(std::move(its_request)) {
    context.set_deadline(std::chrono::system_clock::now() + kTimeout);
  }
  grpc::ClientContext context;
  const std::shared_ptr<Stub> stub;
  const Request request;
  Response response;
};

void CheckHealth(const std::shared_ptr<grpc::GenericStub>& stub, bool wait_for_ready,
                 Latencies& latencies) {
  using HealthCall = Call<grpc::GenericStub, grpc::ByteBuffer, grpc::ByteBuffer>;
  const grpc::Slice empty;  // checks the server as a whole
  auto call = std::make_shared<HealthCall>(stub, grpc::ByteBuffer(&empty, 1));
  call->context.set_wait_for_ready(wait_for_ready);
  latencies.Begin();
  const auto begin = Clock::now();
  stub->UnaryCall(&call->context, "/grpc.health.v1.Health/Check", {}, &call->request,
                  &call->response, [&latencies, call, begin](grpc::Status status) mutable {
                    call.reset();
                    latencies.End(begin, status);
                  });
}

void Recognize(const std::shared_ptr<v1::QueryService::Stub>& stub,
               const v1::RecognizeRequest& request, const std::string& token,
               Latencies& latencies) {
  using RecognizeCall = Call<v1::QueryService::Stub, v1::RecognizeRequest, v1::RecognizeResponse>;
  auto call = std::make_shared<RecognizeCall>(stub, request);
  if (!token.empty()) call->context.AddMetadata("authorization", "Bearer " + token);
  latencies.Begin();
  const auto begin = Clock::now();
  stub->async()->Recognize(&call->context, &call->request, &call->response,
                           [&latencies, call, begin](grpc::Status status) mutable {
                             call.reset();
                             latencies.End(begin, status);
                           });
}

// Requests with successive windows of the motion.
std::vector<v1::RecognizeRequest> Windows(const client::Client& client, const std::string& database,
                                          const std::string& file) {
  v1::RepresentRequest represent;
  represent.set_database("databases/" + database);
  auto& motion = *represent.mutable_observation()->mutable_file();
  motion.set_file_name("motion.bvh");
  std::ifstream stream(file, std::ios::binary);
  motion.set_data(std::string(std::istreambuf_iterator<char>(stream), {}));
  const auto represented = client.Represent(represent);
  if (!represented.ok()) throw std::runtime_error(represented.status().ToString());
  const v1::MarkerObservation& whole = represented->markers();
  const int frames = static_cast<int>(std::lround(kWindowSeconds * whole.frame_rate_hz()));
  const auto width = whole.positions().size() / static_cast<std::size_t>(whole.frame_count());
  std::vector<v1::RecognizeRequest> requests;
  for (int first = 0; first + frames <= whole.frame_count(); first += frames) {
    v1::RecognizeRequest& request = requests.emplace_back();
    request.set_database(represent.database());
    v1::MarkerObservation& window = *request.mutable_observation()->mutable_markers();
    window = whole;
    window.set_frame_count(frames);
    window.set_positions(whole.positions().substr(static_cast<std::size_t>(first) * width,
                                                  static_cast<std::size_t>(frames) * width));
  }
  if (requests.empty()) throw std::runtime_error(file + ": shorter than 0.4 s");
  return requests;
}

// Returns whether standard input ended before `time`.
bool InputEndedBy(Clock::time_point time) {
  const auto left = std::chrono::ceil<milliseconds>(time - Clock::now());
  pollfd input{.fd = 0, .events = POLLIN, .revents = 0};
  return poll(&input, 1, std::max(0, static_cast<int>(left.count()))) > 0;
}

void Run(const client::ClientOptions& options, const std::string& database,
         const std::string& file) {
  auto client = client::Client::Connect(options);
  if (!client.ok()) throw std::runtime_error(client.status().ToString());
  const std::vector<v1::RecognizeRequest> requests = Windows(*client, database, file);
  const auto channel = NewChannel(options);
  const auto health_stub = std::make_shared<grpc::GenericStub>(channel);
  const std::shared_ptr<v1::QueryService::Stub> query_stub = v1::QueryService::NewStub(channel);
  Latencies warm_up, health, recognize, connect;
  for (const v1::RecognizeRequest& request : requests) {
    Recognize(query_stub, request, options.token, warm_up);
  }
  const nlohmann::json warmed_up = warm_up.Summary();
  if (warmed_up["failures"] != 0) throw std::runtime_error(warmed_up.dump());
  fmt::print("ready\n");
  std::fflush(stdout);

  const auto begin = Clock::now();
  for (int tick = 0; !InputEndedBy(begin + tick * kHealthPeriod); ++tick) {
    CheckHealth(health_stub, false, health);
    if (tick % kTicksPerRecognize == 0) {
      const auto number = static_cast<std::size_t>(tick / kTicksPerRecognize);
      Recognize(query_stub, requests[number % requests.size()], options.token, recognize);
    }
    if (tick % kTicksPerConnect == kTicksPerConnect / 2) {
      CheckHealth(std::make_shared<grpc::GenericStub>(NewChannel(options)), true, connect);
    }
  }
  const nlohmann::json summary = {{"health", health.Summary()},
                                  {"recognize", recognize.Summary()},
                                  {"connect", connect.Summary()}};
  fmt::print("{}\n", summary.dump());
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) {
  motiondb::client::ClientOptions options;
  motiondb::client::TlsOptions tls;
  std::string database, motion;
  CLI::App app("steady_client: measures a server under attack");
  app.add_option("--server", options.server, "HOST:PORT")->required();
  app.add_option("--tls-ca", tls.ca_file, "Authority of the server's certificate (PEM)");
  app.add_option("--token", options.token, "Token, with TLS or on loopback");
  app.add_option("--database", database, "Database to query")->required();
  app.add_option("--motion", motion, "BVH file whose windows are recognized")->required();
  CLI11_PARSE(app, argc, argv);
  if (!tls.ca_file.empty()) options.tls = tls;
  try {
    motiondb::tests::Run(options, database, motion);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "steady_client: {}\n", error.what());
    return 1;
  }
}
