// Client::Observe: servers that die or stop during a stream.
#include <grpcpp/grpcpp.h>
#include <motiondb/client.h>
#include <motiondb/v1/observe.grpc.pb.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <mutex>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "tests/client/connect.h"

namespace motiondb::tests::observe_reconnect_test {
namespace {

using Catch::Contains;
using client::Client;
using client::ObserveReconnect;
using client::ObserveStream;

constexpr double kRate_hz = 100;  // so 100 frames are kept

// What a server does with one stream.
struct Script {
  int answers = 1 << 20;  // to so many messages
  int unanswered = 0;     // then reads so many messages without an answer
  int code = 14;          // then ends with this code
  std::size_t answer_bytes = 0;
};

// Answers Observe as its scripts say, the last one from then on. Counts frames as motiondbd does.
class ObservingServer final : public v1::ObserveService::Service {
 public:
  ObservingServer(int model_version, std::vector<Script> scripts)
      : model_version_(model_version), scripts_(std::move(scripts)) {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
  }
  ~ObservingServer() override { server_->Shutdown(std::chrono::system_clock::now()); }

  const std::string& address() const { return address_; }
  // The number of the first frame of each message, by stream.
  using Streams = std::vector<std::vector<std::int64_t>>;
  Streams streams() const {
    const std::lock_guard lock(mutex_);
    return streams_;
  }

 private:
  using Stream = grpc::ServerReaderWriter<v1::ObserveResponse, v1::ObserveRequest>;

  grpc::Status Observe(grpc::ServerContext*, Stream* stream) override {
    const Script script = NextScript();
    v1::ObserveRequest request;
    if (!stream->Read(&request) || !request.has_start()) return {grpc::INTERNAL, "no start"};
    v1::ObserveResponse answer;
    answer.set_model_version(model_version_);
    answer.add_labels()->set_label(std::string(script.answer_bytes, 'x'));
    std::int64_t next = -1;
    for (int messages = 0; messages < script.answers + script.unanswered; ++messages) {
      if (!stream->Read(&request)) return grpc::Status::OK;
      const v1::ObservedFrames& frames = request.frames();
      {
        const std::lock_guard lock(mutex_);
        streams_.back().push_back(frames.first_frame());
      }
      if (next >= 0 && frames.first_frame() > next) {
        answer.set_missing_frames(answer.missing_frames() + frames.first_frame() - next);
      }
      if (frames.first_frame() < next) answer.set_late_frames(answer.late_frames() + 1);
      next = std::max(next, frames.first_frame() + frames.frame_count());
      answer.set_frame(next - 1);
      if (messages < script.answers) stream->Write(answer);
    }
    return {static_cast<grpc::StatusCode>(script.code), "the end of the script"};
  }

  Script NextScript() {
    const std::lock_guard lock(mutex_);
    streams_.emplace_back();
    const Script script = scripts_.front();
    if (scripts_.size() > 1) scripts_.erase(scripts_.begin());
    return script;
  }

  const int model_version_;
  mutable std::mutex mutex_;
  std::vector<Script> scripts_;
  Streams streams_;
  std::string address_;
  std::unique_ptr<grpc::Server> server_;
};

v1::ObserveStart StartOf(double window_seconds = 0.4) {
  v1::ObserveStart start;
  start.set_database("databases/walks");
  start.set_frame_rate_hz(kRate_hz);
  start.set_window_seconds(window_seconds);
  return start;
}

const std::vector<float> kOneFrame(3, 0.5F);

std::vector<std::int64_t> Range(std::int64_t first, std::int64_t end) {
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(end - first));
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

struct Observed {
  std::vector<std::int64_t> frames;  // of the answers
  v1::ObserveResponse last;
  std::vector<std::int64_t> replaced;  // frames with model_replaced
  std::vector<ObserveReconnect> reconnects;
  absl::Status end;
};

void Take(const v1::ObserveResponse& answer, Observed& observed) {
  observed.frames.push_back(answer.frame());
  if (answer.model_replaced()) observed.replaced.push_back(answer.frame());
  observed.last = answer;
}

// Sends the frames in messages of one, without waiting for answers.
Observed ObserveAll(const Client& client, const std::vector<std::int64_t>& frames,
                    const v1::ObserveStart& start = StartOf(),
                    const std::vector<float>& positions = kOneFrame) {
  Observed observed;
  ObserveStream stream = client.Observe(start, {.on_reconnect = [&](const ObserveReconnect& lost) {
                                          observed.reconnects.push_back(lost);
                                        }});
  std::thread sender([&] {
    for (const std::int64_t frame : frames) {
      if (!stream.Send(frame, 1, positions)) return;
    }
    stream.EndOfFrames();
  });
  v1::ObserveResponse answer;
  while (stream.Receive(answer)) Take(answer, observed);
  sender.join();
  observed.end = stream.Finish();
  return observed;
}

TEST_CASE("Observe: after the death of the server each frame has one answer, in order",
          "[client]") {
  ObservingServer a(1, {{.answers = 150, .unanswered = GENERATE(0, 1, 10)}});
  const ObservingServer b(1, {{}});
  const Observed seen = ObserveAll(ConnectTo(a.address() + "," + b.address()), Range(0, 400));
  CHECK(seen.end.ok());
  CHECK(seen.frames == Range(0, 400));
  // Of the answered frames 0 to 149, the last 100 are sent again.
  REQUIRE(seen.reconnects.size() == 1);
  CHECK(seen.reconnects[0].lost_frames == 50);
  CHECK(seen.reconnects[0].first_frame == 50);
  CHECK(absl::IsUnavailable(seen.reconnects[0].error));
  CHECK_THAT(std::string(seen.reconnects[0].error.message()), Contains(a.address()));
  CHECK(b.streams() == ObservingServer::Streams{Range(50, 400)});
  CHECK(seen.replaced.empty());
}

TEST_CASE("Observe: servers die again and again, also while frames are sent again", "[client]") {
  const ObservingServer a(1, {{.answers = 120}, {.answers = 60}, {.answers = 130}, {}});
  const ObservingServer b(
      2, {{.answers = 0, .unanswered = 1}, {.answers = 40, .unanswered = 3}, {.answers = 160}});
  const Observed seen = ObserveAll(ConnectTo(a.address() + "," + b.address()), Range(1000, 1400));
  CHECK(seen.end.ok());
  CHECK(seen.frames == Range(1000, 1400));
  // Only a server that answered is reported. All lost frames count, from the beginning on.
  std::int64_t earlier = 0;
  for (const ObserveReconnect& reconnect : seen.reconnects) {
    CHECK(reconnect.first_frame == 1000 + reconnect.lost_frames);
    CHECK(reconnect.lost_frames >= earlier);
    earlier = reconnect.lost_frames;
  }
  CHECK(seen.reconnects.size() == 5);
  CHECK(!seen.replaced.empty());  // of the other server
}

TEST_CASE("Observe: flow control does not stop a stream that continues", "[client]") {
  // More than the windows of HTTP/2 in both directions.
  constexpr std::size_t kAnswerBytes = 200'000;
  const std::size_t floats = GENERATE(3, 1000, 100'000);
  const ObservingServer a(1, {{.answers = 110, .answer_bytes = kAnswerBytes}});
  const ObservingServer b(1, {{.answer_bytes = kAnswerBytes}});
  const Observed seen = ObserveAll(ConnectTo(a.address() + "," + b.address()), Range(0, 150),
                                   StartOf(), std::vector<float>(floats));
  CHECK(seen.end.ok());
  CHECK(seen.frames == Range(0, 150));
  CHECK(seen.reconnects.size() == 1);
}

TEST_CASE("Observe: a longer window keeps more frames", "[client]") {
  const ObservingServer a(1, {{.answers = 300}});
  const ObservingServer b(1, {{}});
  const Observed seen =
      ObserveAll(ConnectTo(a.address() + "," + b.address()), Range(0, 301), StartOf(2.5));
  CHECK(seen.frames == Range(0, 301));
  REQUIRE(seen.reconnects.size() == 1);
  CHECK(seen.reconnects[0].lost_frames == 50);
  CHECK(b.streams() == ObservingServer::Streams{Range(50, 301)});
}

TEST_CASE("Observe: one thread that sends and receives in turn continues", "[client]") {
  const ObservingServer a(1, {{.answers = 3}, {}});
  const Client client = ConnectTo(a.address());
  ObserveStream stream = client.Observe(StartOf());
  v1::ObserveResponse answer;
  for (int frame = 0; frame < 10; ++frame) {
    REQUIRE(stream.Send(frame, 1, kOneFrame));
    REQUIRE(stream.Receive(answer));
    CHECK(answer.frame() == frame);
  }
  stream.EndOfFrames();
  CHECK(!stream.Receive(answer));
  CHECK(stream.Finish().ok());
  CHECK(a.streams() == ObservingServer::Streams{Range(0, 3), Range(0, 10)});
}

TEST_CASE("Observe: counts of late and missing frames, and the model, continue", "[client]") {
  const ObservingServer a(4, {{.answers = 200}});
  const ObservingServer b(5, {{}});
  std::vector<std::int64_t> frames = Range(0, 10);
  frames.push_back(3);  // late, and forgotten at the end
  for (const std::int64_t frame : Range(15, 190)) frames.push_back(frame);
  frames.insert(frames.end(), {20, 192, 195, 196, 30});  // late twice; missing 190, 191, 193, 194
  for (const std::int64_t frame : Range(197, 300)) frames.push_back(frame);
  const Observed seen = ObserveAll(ConnectTo(a.address() + "," + b.address()), frames);
  CHECK(seen.frames.size() == frames.size());
  CHECK(seen.last.late_frames() == 3);
  CHECK(seen.last.missing_frames() == 5 + 4);
  REQUIRE(seen.replaced.size() == 1);
}

TEST_CASE("Observe: a stream that ends names the frames without an answer", "[client]") {
  const ObservingServer a(1, {{.answers = 5, .unanswered = 2}});
  const Client client = ConnectTo(a.address());
  ObserveStream stream =
      client.Observe(StartOf(), {.reconnect_timeout = std::chrono::milliseconds(0)});
  for (int frame = 0; frame < 7; ++frame) REQUIRE(stream.Send(frame, 1, kOneFrame));
  v1::ObserveResponse answer;
  int answers = 0;
  while (stream.Receive(answer)) ++answers;
  CHECK(answers == 5);
  CHECK(!stream.Send(7, 1, kOneFrame));
  const absl::Status end = stream.Finish();
  CHECK(absl::IsUnavailable(end));
  CHECK_THAT(std::string(end.message()), Contains("; 2 frames from frame 5 on have no answer"));
}

TEST_CASE("Observe: all frames have an answer, only the end is lost", "[client]") {
  const ObservingServer a(1, {{.answers = 5}});
  const Client client = ConnectTo(a.address());
  ObserveStream stream = client.Observe(StartOf());
  for (int frame = 0; frame < 5; ++frame) REQUIRE(stream.Send(frame, 1, kOneFrame));
  stream.EndOfFrames();
  v1::ObserveResponse answer;
  int answers = 0;
  while (stream.Receive(answer)) ++answers;
  CHECK(answers == 5);
  CHECK(stream.Finish().ok());
}

TEST_CASE("Observe: ends with an error that another server does not fix", "[client]") {
  const ObservingServer a(1, {{.answers = 0, .code = 5}});
  const ObservingServer b(1, {{}});
  const Observed seen = ObserveAll(ConnectTo(a.address() + "," + b.address()), Range(0, 3));
  CHECK(absl::IsNotFound(seen.end));
  CHECK(b.streams().empty());
}

TEST_CASE("Observe: Cancel ends it while no server is found", "[client]") {
  auto a = std::make_unique<ObservingServer>(1, std::vector<Script>{{}});
  const Client client = ConnectTo(a->address());
  ObserveStream stream = client.Observe(StartOf());
  v1::ObserveResponse answer;
  REQUIRE(stream.Send(0, 1, kOneFrame));
  REQUIRE(stream.Receive(answer));
  a.reset();
  std::thread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    stream.Cancel();
  });
  CHECK(!stream.Receive(answer));
  canceller.join();
  CHECK(absl::IsCancelled(stream.Finish()));
}

TEST_CASE("Observe: without a server, Send blocks after some MiB until the stream ends",
          "[client]") {
  auto a = std::make_unique<ObservingServer>(1, std::vector<Script>{{}});
  const Client client = ConnectTo(a->address());
  ObserveStream stream =
      client.Observe(StartOf(), {.reconnect_timeout = std::chrono::milliseconds(600)});
  a.reset();
  int sent = 0;
  std::thread sender([&] {
    const std::vector<float> mebibyte((1 << 20) / sizeof(float));
    while (sent < 100 && stream.Send(sent, 1, mebibyte)) ++sent;
  });
  v1::ObserveResponse answer;
  CHECK(!stream.Receive(answer));
  sender.join();
  CHECK(sent >= 8);
  CHECK(sent < 20);
  CHECK(absl::IsUnavailable(stream.Finish()));
}

}  // namespace
}  // namespace motiondb::tests::observe_reconnect_test
