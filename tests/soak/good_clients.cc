#include "tests/soak/good_clients.h"

#include <fmt/format.h>

#include <chrono>
#include <cstring>
#include <deque>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "motiondb/v1/plan.pb.h"
#include "motiondb/v1/query.pb.h"
#include "tests/soak/broken_clients.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;

constexpr char kDatabase[] = "databases/soak";
constexpr std::size_t kMaxClips = 40;

template <typename T>
void Require(const absl::StatusOr<T>& result) {
  if (!result.ok()) throw std::runtime_error(result.status().ToString());
}

void Pause(int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

std::string Figure(int number, int frames) {
  constexpr Act kActs[] = {Act::kWalk, Act::kSquat, Act::kWave};
  return WriteBvh({.act = kActs[number % 3],
                   .frame_count = frames,
                   .phase = 0.1 * number,
                   .tempo = 0.8 + 0.01 * (number % 40)});
}

absl::StatusOr<v1::IngestClipResponse> Ingest(const client::Client& client,
                                              const std::string& database, int number) {
  constexpr const char* kLabels[] = {"walk", "squat", "wave"};
  v1::IngestClipHeader header;
  header.set_parent(database);
  header.set_file_name(fmt::format("clip{}.bvh", number));
  header.set_label(kLabels[number % 3]);
  return client.IngestBytes(header, Figure(number, 120 + 10 * (number % 20)));
}

absl::Status CreateDatabase(const client::Client& client, const std::string& id) {
  v1::CreateDatabaseRequest request;
  request.set_database_id(id);
  request.mutable_database()->set_marker_set("source");
  return client.CreateDatabase(request).status();
}

int MarkerCount(const v1::MarkerObservation& motion) {
  return static_cast<int>(motion.positions().size() / sizeof(float) / 3 /
                          static_cast<std::size_t>(motion.frame_count()));
}

// Frames [first, first + count) of the walk.
v1::MarkerObservation Part(const v1::MarkerObservation& walk, int first, int count) {
  const std::size_t width = walk.positions().size() / static_cast<std::size_t>(walk.frame_count());
  v1::MarkerObservation part;
  part.set_frame_rate_hz(walk.frame_rate_hz());
  if (walk.has_leg_length_m()) part.set_leg_length_m(walk.leg_length_m());
  part.set_frame_count(count);
  part.set_positions(walk.positions().substr(static_cast<std::size_t>(first) * width,
                                             static_cast<std::size_t>(count) * width));
  return part;
}

// An ingest that its client cancels halfway. The clip may be stored although the client has no
// answer, so a figure with this number must not be used again.
void IngestWithShortDeadline(const client::Client& client, int number,
                             std::chrono::milliseconds timeout, Tally& tally) {
  v1::IngestClipHeader header;
  header.set_parent(kDatabase);
  header.set_file_name("late.bvh");
  tally.Add("Ingest with too short a deadline",
            client.IngestBytes(header, Figure(number, 2000), {}, {.timeout = timeout}).status(),
            {StatusCode::kDeadlineExceeded, StatusCode::kCancelled});
}

// Deletes those that were stored after all; otherwise the database would grow during the run.
void DeleteLateClips(const client::Client& client, Tally& tally) {
  v1::ListClipsRequest request;
  request.set_parent(kDatabase);
  const auto clips = client.AllClips(request);
  tally.Add("List", clips.status());
  if (!clips.ok()) return;
  for (const v1::Clip& clip : *clips) {
    if (!clip.name().starts_with(fmt::format("{}/clips/late", kDatabase))) continue;
    v1::DeleteClipRequest remove;
    remove.set_name(clip.name());
    // Another such client may have deleted it.
    tally.Add("Delete late", client.DeleteClip(remove).status(), {StatusCode::kNotFound});
  }
}

}  // namespace

client::Client Connect(const Soak& soak) {
  client::ClientOptions options;
  options.server = soak.address;
  auto client = client::Client::Connect(options);
  Require(client);
  return *std::move(client);
}

void Prepare(Soak& soak) {
  const client::Client client = Connect(soak);
  if (const absl::Status made = CreateDatabase(client, "soak"); !made.ok()) {
    throw std::runtime_error(made.ToString());
  }
  for (int number = 0; number < 3; ++number) {
    const auto ingested = Ingest(client, kDatabase, number);
    Require(ingested);
    soak.clips.insert(ingested->clip().name());
    Require(client.WaitOperation(ingested->operation().name()));
  }
  v1::RepresentRequest request;
  request.set_database(kDatabase);
  v1::FileObservation& file = *request.mutable_observation()->mutable_file();
  file.set_file_name("walk.bvh");
  file.set_data(Figure(3000, 240));
  const auto represented = client.Represent(request);
  Require(represented);
  soak.walk = represented->markers();
}

void IngestAndDelete(Soak& soak) {
  const client::Client client = Connect(soak);
  std::deque<std::string> stored;
  for (int number = 3; !soak.over; ++number) {
    const auto ingested = Ingest(client, kDatabase, number);
    soak.tally.Add("Ingest", ingested.status());
    if (ingested.ok()) {
      stored.push_back(ingested->clip().name());
      const std::lock_guard lock(soak.mutex);
      soak.clips.insert(stored.back());
    }
    if (stored.size() > kMaxClips) {
      v1::DeleteClipRequest request;
      request.set_name(stored.front());
      const auto deleted = client.DeleteClip(request);
      soak.tally.Add("Delete", deleted.status());
      const std::lock_guard lock(soak.mutex);
      if (deleted.ok()) soak.clips.erase(stored.front());
      stored.pop_front();
    }
    Pause(500);
  }
}

void SendAllQueries(Soak& soak, unsigned seed) {
  const client::Client client = Connect(soak);
  std::mt19937 random(seed);
  while (!soak.over) {
    const int first = static_cast<int>(random() % 180);
    const v1::MarkerObservation seen = Part(soak.walk, first, 30);
    v1::RecognizeRequest recognize;
    recognize.set_database(kDatabase);
    *recognize.mutable_observation()->mutable_markers() = seen;
    soak.tally.Add("Recognize", client.Recognize(recognize).status());
    v1::EstimateRequest estimate;
    estimate.set_database(kDatabase);
    *estimate.mutable_observation()->mutable_markers() = seen;
    soak.tally.Add("Estimate", client.Estimate(estimate).status());
    v1::PredictRequest predict;
    predict.set_database(kDatabase);
    *predict.mutable_observation()->mutable_markers() = seen;
    soak.tally.Add("Predict", client.Predict(predict).status());
    if (random() % 10 == 0) {
      v1::PlanRequest plan;
      plan.set_database(kDatabase);
      plan.mutable_goal()->set_x_m(1);
      plan.mutable_search_timeout()->set_nanos(200'000'000);
      soak.tally.Add("Plan", client.Plan(plan).status(),
                     {StatusCode::kNotFound, StatusCode::kFailedPrecondition});
    }
    Pause(20);
  }
}

void Watch(Soak& soak, unsigned seed) {
  const client::Client client = Connect(soak);
  std::mt19937 random(seed);
  const int markers = MarkerCount(soak.walk);
  std::vector<float> frame(static_cast<std::size_t>(3 * markers));
  const std::size_t width = frame.size() * sizeof(float);
  while (!soak.over) {
    v1::ObserveStart start;
    start.set_database(kDatabase);
    start.set_frame_rate_hz(60);
    client::ObserveStream stream = client.Observe(start);
    const int frames = 60 + static_cast<int>(random() % 600);
    v1::ObserveResponse answer;
    bool open = true;
    for (int f = 0; f < frames && open && !soak.over; ++f) {
      std::memcpy(frame.data(),
                  soak.walk.positions().data() +
                      static_cast<std::size_t>(f % soak.walk.frame_count()) * width,
                  width);
      open = stream.Send(f, 1, frame) && stream.Receive(answer);
      Pause(16);
    }
    // One in four cancels.
    if (open && random() % 4 == 0) {
      stream.Cancel();
      stream.Finish().IgnoreError();
      continue;
    }
    stream.EndOfFrames();
    while (stream.Receive(answer)) {
    }
    soak.tally.Add("Observe", stream.Finish());
  }
}

void Administer(Soak& soak) {
  const client::Client client = Connect(soak);
  for (int round = 0; !soak.over; ++round) {
    const std::string id = fmt::format("passing{}", round);
    soak.tally.Add("Create", CreateDatabase(client, id));
    for (int number = 0; number < 3; ++number) {
      soak.tally.Add("Ingest", Ingest(client, "databases/" + id, number).status());
    }
    soak.tally.Add("List", client.AllDatabases().status());
    v1::ListClipsRequest clips;
    clips.set_parent(kDatabase);
    soak.tally.Add("List", client.AllClips(clips).status());
    v1::GetDatabaseRequest describe;
    describe.set_view(v1::DATABASE_VIEW_FULL);
    describe.set_name(kDatabase);
    soak.tally.Add("Describe", client.GetDatabase(describe).status());
    for (int i = 0; i < 20 && !soak.over; ++i) Pause(100);
    v1::DeleteDatabaseRequest remove;
    remove.set_name("databases/" + id);
    soak.tally.Add("Delete", client.DeleteDatabase(remove).status());
  }
}

void Misbehave(Soak& soak, unsigned seed) {
  const client::Client client = Connect(soak);
  std::mt19937 random(seed);
  for (int round = 0; !soak.over; ++round) {
    SendNoise(soak.address, random);
    IngestGarbage(client, random, soak.tally);
    SendInvalidQueries(client, random, soak.tally);
    ObserveWithoutReading(client, "soak", soak.walk.positions(), soak.walk.frame_count(),
                          MarkerCount(soak.walk), 0.5);
    IngestWithShortDeadline(client, 10000 * static_cast<int>(seed) + round,
                            std::chrono::milliseconds(1 + random() % 5), soak.tally);
    if (round % 10 == 9) DeleteLateClips(client, soak.tally);
  }
}

}  // namespace motiondb::tests
