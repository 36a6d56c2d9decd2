#include "tests/bench/client_load.h"

#include <fmt/format.h>
#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/support/channel_arguments.h>

#include <algorithm>
#include <barrier>
#include <cmath>
#include <ctime>
#include <thread>
#include <utility>

#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"

namespace motiondb::tests {
namespace {
using Clock = std::chrono::steady_clock;

std::shared_ptr<grpc::Channel> NewChannel(const std::string& address) {
  grpc::ChannelArguments arguments;
  // A connection of its own, not the shared one of the address.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

absl::Status Failed(std::string_view call, const grpc::Status& status) {
  return absl::Status(static_cast<absl::StatusCode>(status.error_code()),
                      fmt::format("{}: {}", call, status.error_message()));
}

double Milliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

class RecognizeClient final : public LoadClient {
 public:
  RecognizeClient(const std::string& address, const std::vector<v1::RecognizeRequest>& requests,
                  std::size_t first)
      : stub_(v1::QueryService::NewStub(NewChannel(address))), requests_(requests), next_(first) {}

  absl::Status Ask() override {
    grpc::ClientContext context;
    const grpc::Status status =
        stub_->Recognize(&context, requests_[next_++ % requests_.size()], &response_);
    return status.ok() ? absl::OkStatus() : Failed("Recognize", status);
  }
  std::string Reply() const override { return response_.SerializeAsString(); }

 private:
  const std::unique_ptr<v1::QueryService::Stub> stub_;
  const std::vector<v1::RecognizeRequest>& requests_;
  v1::RecognizeResponse response_;
  std::size_t next_;
};

class ObserveClient final : public LoadClient {
 public:
  ObserveClient(const std::string& address, const v1::ObserveRequest* start,
                std::vector<v1::ObserveRequest> messages)
      : stub_(v1::ObserveService::NewStub(NewChannel(address))),
        messages_(std::move(messages)),
        stream_(stub_->Observe(&context_)) {
    if (start != nullptr) stream_->Write(*start);
  }
  ~ObserveClient() override {
    if (over_) return;
    stream_->WritesDone();
    while (stream_->Read(&response_)) {
    }
    stream_->Finish();
  }

  absl::Status Ask() override {
    v1::ObserveRequest& message = messages_[next_++ % messages_.size()];
    message.mutable_frames()->set_first_frame(frame_);
    frame_ += message.frames().frame_count();
    if (stream_->Write(message) && stream_->Read(&response_)) return absl::OkStatus();
    over_ = true;
    return Failed("Observe ended", stream_->Finish());
  }
  std::string Reply() const override { return response_.SerializeAsString(); }

 private:
  const std::unique_ptr<v1::ObserveService::Stub> stub_;
  std::vector<v1::ObserveRequest> messages_;
  grpc::ClientContext context_;
  const std::unique_ptr<grpc::ClientReaderWriter<v1::ObserveRequest, v1::ObserveResponse>> stream_;
  v1::ObserveResponse response_;
  std::size_t next_ = 0;
  std::int64_t frame_ = 0;
  bool over_ = false;
};

}  // namespace

double Load::LatencyQuantile(double part) const {
  if (ms.empty()) return std::nan("");
  std::vector<double> sorted = ms;
  const auto rank = std::ceil(part * static_cast<double>(sorted.size()));
  const auto place = sorted.begin() + std::max<std::ptrdiff_t>(0, std::lround(rank) - 1);
  std::nth_element(sorted.begin(), place, sorted.end());
  return *place;
}

void Load::Add(const Load& more) {
  ms.insert(ms.end(), more.ms.begin(), more.ms.end());
  seconds += more.seconds;
  processor_seconds += more.processor_seconds;
}

std::unique_ptr<LoadClient> NewRecognizeClient(const std::string& address,
                                               const std::vector<v1::RecognizeRequest>& requests,
                                               std::size_t first) {
  return std::make_unique<RecognizeClient>(address, requests, first);
}

std::unique_ptr<LoadClient> NewObserveClient(const std::string& address,
                                             const v1::ObserveRequest* start,
                                             std::vector<v1::ObserveRequest> messages) {
  return std::make_unique<ObserveClient>(address, start, std::move(messages));
}

absl::StatusOr<Load> RunConcurrently(const std::vector<std::unique_ptr<LoadClient>>& clients,
                                     int warm_up, Seconds duration) {
  const auto count = static_cast<std::ptrdiff_t>(clients.size());
  Clock::time_point begin;
  std::clock_t processor_begin = 0;
  std::barrier ready(count, [&]() noexcept {
    begin = Clock::now();
    processor_begin = std::clock();
  });
  std::vector<Load> loads(clients.size());
  std::vector<absl::Status> statuses(clients.size());
  const auto run = [&](std::size_t c) {
    for (int i = 0; i < warm_up && statuses[c].ok(); ++i) statuses[c] = clients[c]->Ask();
    ready.arrive_and_wait();
    const auto end = begin + duration;
    auto now = Clock::now();
    while (now < end && statuses[c].ok()) {
      const auto asked = now;
      statuses[c] = clients[c]->Ask();
      now = Clock::now();
      loads[c].ms.push_back(Milliseconds(now - asked));
    }
  };
  std::vector<std::thread> threads;
  for (std::size_t c = 0; c < clients.size(); ++c) threads.emplace_back(run, c);
  for (std::thread& thread : threads) thread.join();
  const double seconds = Seconds(Clock::now() - begin).count();
  const double processor_seconds =
      static_cast<double>(std::clock() - processor_begin) / CLOCKS_PER_SEC;
  Load all;
  for (std::size_t c = 0; c < clients.size(); ++c) {
    if (!statuses[c].ok()) return statuses[c];
    all.Add(loads[c]);
  }
  all.seconds = seconds;
  all.processor_seconds = processor_seconds;
  return all;
}

absl::StatusOr<Load> RunPeriodically(LoadClient& client, Seconds period,
                                     const std::function<bool()>& going) {
  const auto begin = Clock::now();
  Load load;
  for (int i = 0; going(); ++i) {
    const auto due = begin + std::chrono::duration_cast<Clock::duration>(i * period);
    std::this_thread::sleep_until(due);
    const absl::Status status = client.Ask();
    if (!status.ok()) return status;
    load.ms.push_back(Milliseconds(Clock::now() - due));
  }
  load.seconds = Seconds(Clock::now() - begin).count();
  return load;
}

}  // namespace motiondb::tests
