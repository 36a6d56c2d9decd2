#include "tests/soak/extreme_calls.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/model.pb.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/plan.pb.h"
#include "motiondb/v1/query.pb.h"
#include "tests/soak/extreme_files.h"

namespace motiondb::tests {
namespace {

constexpr client::CallOptions kCallTimeout{std::chrono::seconds(5)};

bool OneIn(std::mt19937& random, unsigned n) { return random() % n == 0; }

int AnyInt(std::mt19937& random, double max) {
  return OneIn(random, 8) ? static_cast<int>(random())
                          : static_cast<int>(Magnitude(random, 1, max)) - 1;
}

template <typename T>
absl::Status StatusOf(const absl::StatusOr<T>& result) {
  return result.status();
}

// A body that stands or walks along a line; some markers are missing, always or sometimes.
void SetMarkers(std::mt19937& random, int marker_count, std::size_t max_bytes,
                v1::MarkerObservation& markers) {
  const auto frame_bytes = static_cast<std::size_t>(12 * marker_count);
  const int frames =
      static_cast<int>(Magnitude(random, 1, static_cast<double>(max_bytes / frame_bytes) + 1));
  std::vector<float> positions;
  positions.reserve(static_cast<std::size_t>(3 * frames * marker_count));
  const unsigned missing = OneIn(random, 2) ? 0 : 1 + random() % 10;
  const float far = OneIn(random, 4) ? 9e4F : 0.0F;
  for (int f = 0; f < frames; ++f) {
    for (int m = 0; m < marker_count; ++m) {
      const bool lost = missing > 0 && m > 0 && (m + (missing > 5 ? f : 0)) % 7 == 3;
      const float angle = static_cast<float>(m) + 0.05F * static_cast<float>(f);
      const float nan = std::numeric_limits<float>::quiet_NaN();
      positions.push_back(lost ? nan : far + 0.2F * std::sin(angle));
      positions.push_back(lost ? nan : far + 0.2F * std::cos(angle));
      positions.push_back(lost ? nan : 0.05F * static_cast<float>(m));
    }
  }
  markers.set_frame_count(frames);
  markers.set_frame_rate_hz(OneIn(random, 2) ? 60 : Magnitude(random, 1e-3, 1e5));
  markers.set_positions(positions.data(), positions.size() * sizeof(float));
  if (OneIn(random, 2)) markers.set_leg_length_m(Magnitude(random, 1e-3, 1e4));
}

std::string SetObservation(std::mt19937& random, const ExtremeSubject& subject,
                           std::size_t max_bytes, v1::Observation& observation) {
  if (OneIn(random, 2)) {
    SetMarkers(random, subject.marker_count, max_bytes, *observation.mutable_markers());
    return "markers";
  }
  ExtremeFile file = MakeExtremeFile(random, max_bytes);
  v1::FileObservation& to = *observation.mutable_file();
  to.set_file_name(file.name);
  to.set_data(std::move(file.bytes));
  to.set_skeleton_file_name(file.skeleton_name);
  to.set_skeleton_data(std::move(file.skeleton));
  return file.name;
}

template <typename Request, typename Send>
ExtremeCall Make(std::string kind, Request request, Send send) {
  const auto size = static_cast<std::int64_t>(request.ByteSizeLong());
  return {std::move(kind), size,
          [request = std::move(request), send](const client::Client& client) {
            return send(client, request);
          }};
}

ExtremeCall Recognize(std::mt19937& random, const ExtremeSubject& subject, std::size_t max_bytes) {
  v1::RecognizeRequest request;
  request.set_database(subject.database);
  const std::string what =
      SetObservation(random, subject, max_bytes, *request.mutable_observation());
  if (OneIn(random, 2)) request.set_window_seconds(Magnitude(random, 1e-6, 1e6));
  if (OneIn(random, 2)) request.set_hop_seconds(Magnitude(random, 1e-6, 1e3));
  request.set_whole(OneIn(random, 3));
  if (OneIn(random, 2)) request.set_method(v1::METHOD_PAPER);
  if (OneIn(random, 2)) request.set_layer(AnyInt(random, 20));
  if (OneIn(random, 3)) request.set_transition_floor(0);
  if (OneIn(random, 2)) request.set_generation(v1::GENERATION_TOP_PATHS);
  if (OneIn(random, 2)) request.set_path_count(AnyInt(random, 101));
  return Make("Recognize of " + what, std::move(request), [](const auto& client, const auto& r) {
    return StatusOf(client.Recognize(r, kCallTimeout));
  });
}

ExtremeCall Estimate(std::mt19937& random, const ExtremeSubject& subject, std::size_t max_bytes) {
  v1::EstimateRequest request;
  request.set_database(subject.database);
  const std::string what =
      SetObservation(random, subject, max_bytes, *request.mutable_observation());
  if (OneIn(random, 2)) request.set_layer(AnyInt(random, 20));
  if (OneIn(random, 2)) request.set_path_count(AnyInt(random, 101));
  if (OneIn(random, 2)) request.set_max_candidates(AnyInt(random, 1e4));
  if (OneIn(random, 3)) request.set_transition_floor(0);
  request.set_fill_every_frame(OneIn(random, 2));
  return Make("Estimate of " + what, std::move(request), [](const auto& client, const auto& r) {
    return StatusOf(client.Estimate(r, kCallTimeout));
  });
}

std::string SetPrediction(std::mt19937& random, const ExtremeSubject& subject,
                          std::size_t max_bytes, v1::PredictRequest& request) {
  request.set_database(subject.database);
  std::string what = SetObservation(random, subject, max_bytes, *request.mutable_observation());
  if (OneIn(random, 2)) request.set_history_seconds(Magnitude(random, 1e-3, 1e6));
  const int horizons = static_cast<int>(Magnitude(random, 1, 1010));
  for (int h = 0; h < horizons; ++h) request.add_horizon_seconds(Magnitude(random, 1e-3, 4000));
  if (OneIn(random, 2)) request.set_layer(AnyInt(random, 20));
  if (OneIn(random, 3)) request.set_transition_floor(0);
  if (OneIn(random, 3)) request.set_method(v1::METHOD_PAPER);
  return what;
}

ExtremeCall Predict(std::mt19937& random, const ExtremeSubject& subject, std::size_t max_bytes) {
  v1::PredictRequest request;
  const std::string what = SetPrediction(random, subject, max_bytes, request);
  return Make("Predict of " + what, std::move(request), [](const auto& client, const auto& r) {
    return StatusOf(client.Predict(r, kCallTimeout));
  });
}

ExtremeCall PredictSeries(std::mt19937& random, const ExtremeSubject& subject,
                          std::size_t max_bytes) {
  v1::PredictSeriesRequest request;
  const std::string what = SetPrediction(random, subject, max_bytes, *request.mutable_prediction());
  request.set_every_seconds(Magnitude(random, 1e-3, 1e3));
  return Make("PredictSeries of " + what, std::move(request),
              [](const auto& client, const auto& r) {
                return client.PredictSeries(
                    r, [](const v1::PredictSeriesResponse&) { return absl::OkStatus(); },
                    {std::chrono::seconds(2)});
              });
}

ExtremeCall Represent(std::mt19937& random, const ExtremeSubject& subject, std::size_t max_bytes) {
  v1::RepresentRequest request;
  request.set_database(subject.database);
  const std::string what =
      SetObservation(random, subject, max_bytes, *request.mutable_observation());
  return Make("Represent of " + what, std::move(request), [](const auto& client, const auto& r) {
    return StatusOf(client.Represent(r, kCallTimeout));
  });
}

ExtremeCall Plan(std::mt19937& random, const ExtremeSubject& subject, std::size_t max_bytes) {
  v1::PlanRequest request;
  request.set_database(subject.database);
  if (OneIn(random, 3)) {
    SetObservation(random, subject, max_bytes, *request.mutable_observation_start());
  }
  request.mutable_goal()->set_x_m(OneIn(random, 2) ? 2 : Magnitude(random, 1e-3, 1e3));
  request.set_max_duration_seconds(Magnitude(random, 1, 120));
  request.mutable_search_timeout()->set_nanos(
      static_cast<int>(1e9 * std::min(Magnitude(random, 0.01, 3), 0.999)));
  if (OneIn(random, 2)) request.set_frame_rate_hz(Magnitude(random, 1, 1000));
  request.set_alternative_count(AnyInt(random, 11));
  request.set_include_files(OneIn(random, 2));
  if (OneIn(random, 3)) request.set_method(v1::PLAN_METHOD_RANDOM_SAMPLING);
  const int discs = OneIn(random, 2) ? 0 : static_cast<int>(Magnitude(random, 1, 1100));
  for (int d = 0; d < discs; ++d) {
    v1::Disc& disc = *request.mutable_obstacles()->add_discs();
    disc.mutable_centre()->set_x_m(Magnitude(random, 0.1, 900));
    disc.mutable_centre()->set_y_m(static_cast<double>(random() % 100) - 50);
    disc.set_radius_m(Magnitude(random, 1e-3, 1));
  }
  return Make("Plan", std::move(request), [](const auto& client, const auto& r) {
    return StatusOf(client.Plan(r, kCallTimeout));
  });
}

ExtremeCall Ingest(std::mt19937& random, const ExtremeSubject& subject, std::size_t max_bytes) {
  ExtremeFile file = MakeExtremeFile(random, max_bytes);
  v1::IngestClipHeader header;
  header.set_parent(subject.sink);
  header.set_file_name(file.name);
  header.set_skeleton_file_name(file.skeleton_name);
  const auto size = static_cast<std::int64_t>(file.bytes.size() + file.skeleton.size());
  return {"Ingest of " + file.name, size,
          [header, file = std::move(file)](const client::Client& client) {
            return StatusOf(client.IngestBytes(header, file.bytes, file.skeleton, kCallTimeout));
          }};
}

ExtremeCall Observe(std::mt19937& random, const ExtremeSubject& subject, std::size_t max_bytes) {
  v1::ObserveStart start;
  start.set_database(subject.database);
  v1::MarkerObservation frames;
  SetMarkers(random, subject.marker_count, std::min<std::size_t>(max_bytes, 1 << 20), frames);
  start.set_frame_rate_hz(frames.frame_rate_hz());
  start.set_window_seconds(Magnitude(random, 1e-3, 100));
  start.set_history_seconds(Magnitude(random, 1e-3, 100));
  const int horizons = static_cast<int>(Magnitude(random, 1, 1010));
  for (int h = 0; h < horizons; ++h) start.add_horizon_seconds(Magnitude(random, 1e-3, 4000));
  const auto size = static_cast<std::int64_t>(start.ByteSizeLong() + frames.positions().size());
  return {"Observe", size, [start, frames](const client::Client& client) {
            client::ObserveStream stream = client.Observe(start, {.timeout = kCallTimeout.timeout});
            const auto* const data = reinterpret_cast<const float*>(frames.positions().data());
            stream.Send(0, frames.frame_count(), {data, frames.positions().size() / sizeof(float)});
            stream.EndOfFrames();
            v1::ObserveResponse answer;
            while (stream.Receive(answer)) {
            }
            return stream.Finish();
          }};
}

ExtremeCall Read(std::mt19937& random, const ExtremeSubject& subject) {
  const std::string model = subject.database + "/models/current";
  switch (random() % 4) {
    case 0: {
      v1::ExportClipRequest request;
      request.set_name(subject.clip);
      ExtremeCall call = Make("ExportClip", request, [](const auto& client, const auto& r) {
        return StatusOf(client.ExportClip(r, kCallTimeout));
      });
      call.size += subject.clip_bytes;
      return call;
    }
    case 1: {
      v1::ListTransitionsRequest request;
      request.set_parent(model);
      request.set_layer(AnyInt(random, 20));
      request.set_page_size(AnyInt(random, 1e6));
      return Make("ListTransitions", request, [](const auto& client, const auto& r) {
        return StatusOf(client.ListTransitions(r, kCallTimeout));
      });
    }
    case 2: {
      v1::ListNodesRequest request;
      request.set_parent(model);
      request.set_layer(AnyInt(random, 20));
      request.set_page_size(AnyInt(random, 1e6));
      return Make("ListNodes", request, [](const auto& client, const auto& r) {
        return StatusOf(client.ListNodes(r, kCallTimeout));
      });
    }
    default: {
      v1::ReadStatesRequest request;
      request.set_name(model);
      return Make("ReadStates", request, [](const auto& client, const auto& r) {
        return client.ReadStates(
            r, [](const v1::ReadStatesResponse&) { return absl::OkStatus(); }, kCallTimeout);
      });
    }
  }
}

}  // namespace

ExtremeCall MakeExtremeCall(std::mt19937& random, const ExtremeSubject& subject,
                            std::size_t max_bytes) {
  const auto call_bytes = static_cast<std::size_t>(
      Magnitude(random, 1000, static_cast<double>(std::max<std::size_t>(max_bytes, 2000))));
  switch (random() % 12) {
    case 0:
    case 1:
    case 2:
      return Recognize(random, subject, call_bytes);
    case 3:
    case 4:
      return Estimate(random, subject, call_bytes);
    case 5:
      return Predict(random, subject, call_bytes);
    case 6:
      return PredictSeries(random, subject, call_bytes);
    case 7:
      return Represent(random, subject, call_bytes);
    case 8:
      return Plan(random, subject, call_bytes);
    case 9:
      return Ingest(random, subject, call_bytes);
    case 10:
      return Observe(random, subject, call_bytes);
    default:
      return Read(random, subject);
  }
}

}  // namespace motiondb::tests
