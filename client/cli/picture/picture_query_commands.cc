// motiondb picture estimate|recognize|plan: pictures of queries.

#include <motiondb/v1/observe.pb.h>
#include <motiondb/v1/plan.pb.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/picture/estimate_picture.h"
#include "client/cli/picture/picture_geometry.h"
#include "client/cli/picture/picture_options.h"
#include "client/cli/plan_request.h"
#include "client/cli/plan_text.h"
#include "client/cli/plot/floor_plan.h"
#include "client/cli/query/query_files.h"
#include "client/cli/query/query_options.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

// ---- estimate -----------------------------------------------------------------------------------

struct EstimatePictureOptions {
  QueryOptions query;
  std::optional<double> at_seconds;
  double history_seconds = 0.4;
  std::vector<double> horizon_seconds = {0.08, 0.16, 0.32, 0.56, 1.0};
  MapOptions map = {.width = 1000, .height = 860};
  std::string out;
};

void DeclareEstimatePicture(CLI::App& command, EstimatePictureOptions& options) {
  AddQueryOptionsOfOneFile(command, options.query);
  AddOutOption(command, options.out);
  AddMapOptions(command, options.map);
  command.remove_option(command.get_option("--colour"));  // nodes have no colours of labels
  command
      .add_option("--at", options.at_seconds, "Time to predict from; else the end of the motion")
      ->type_name("SECONDS")
      ->check(NonNegativeNumber());
  command
      .add_option("--history", options.history_seconds,
                  "Length of the motion before that time that is used")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
  command.add_option("--horizon", options.horizon_seconds, "Horizons of the predicted poses")
      ->type_name("SECONDS,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->expected(1, 8)
      ->check(PositiveNumber())
      ->capture_default_str();
}

// Frames of the motion as the server represents it.
class RepresentedMotion {
 public:
  explicit RepresentedMotion(const v1::MarkerObservation& markers)
      : positions_(UnpackFloats(markers.positions())),
        frame_rate_hz_(markers.frame_rate_hz()),
        frame_count_(static_cast<std::size_t>(std::max(markers.frame_count(), 0))) {}

  // Returns the pose at a time (s); empty after the end.
  Pose At(double seconds) const {
    if (frame_count_ == 0 || !(seconds >= 0)) return {};
    const double frame = std::round(seconds * frame_rate_hz_);
    if (!(frame < static_cast<double>(frame_count_) + 0.5)) return {};
    const std::size_t index = std::min(static_cast<std::size_t>(frame), frame_count_ - 1);
    const std::size_t size = positions_.size() / frame_count_;
    const auto begin = positions_.begin() + static_cast<std::ptrdiff_t>(index * size);
    return Pose(begin, begin + static_cast<std::ptrdiff_t>(size));
  }

 private:
  std::vector<float> positions_;
  double frame_rate_hz_;
  std::size_t frame_count_;
};

// Returns the nodes of the best path up to the moment.
std::vector<int> PathUntil(const v1::EstimateResponse& response, double seconds) {
  std::vector<int> path;
  if (response.paths_size() == 0) return path;
  const auto& nodes = response.paths(0).node_ids();
  const double frames = std::floor(seconds * response.frame_rate_hz() + 1e-6) + 1;
  const int count = frames < nodes.size() ? static_cast<int>(frames) : nodes.size();
  path.assign(nodes.begin(), nodes.begin() + std::max(count, 0));
  return path;
}

absl::StatusOr<EstimatedMotion> AskForMotion(const Client& client,
                                             const EstimatePictureOptions& options,
                                             const v1::Observation& observation) {
  v1::PredictRequest predict;
  SetQuery(options.query, predict);
  *predict.mutable_observation() = observation;
  if (options.at_seconds) predict.set_at_seconds(*options.at_seconds);
  predict.set_history_seconds(options.history_seconds);
  for (const double horizon : options.horizon_seconds) predict.add_horizon_seconds(horizon);
  auto prediction = client.Predict(predict);
  if (!prediction.ok()) return prediction.status();
  v1::EstimateRequest estimate;
  SetQuery(options.query, estimate);
  *estimate.mutable_observation() = observation;
  const auto estimated = client.Estimate(estimate);
  if (!estimated.ok()) return estimated.status();
  v1::RepresentRequest represent;
  represent.set_database(predict.database());
  *represent.mutable_observation() = observation;
  const auto represented = client.Represent(represent);
  if (!represented.ok()) return represented.status();

  EstimatedMotion motion;
  motion.file = std::filesystem::path(options.query.files.front()).filename().string();
  motion.path = PathUntil(*estimated, prediction->at_seconds());
  const RepresentedMotion frames(represented->markers());
  motion.now = frames.At(prediction->at_seconds());
  std::vector<int> next;
  for (const v1::NextNode& node : prediction->next_nodes()) {
    if (static_cast<int>(next.size()) < kNextPoses) next.push_back(node.node_id());
  }
  auto poses = ReadMeanPoses(client, options.query.database, prediction->layer(), next);
  if (!poses.ok()) return poses.status();
  motion.next = *std::move(poses);
  for (const v1::PredictedFrame& horizon : prediction->horizons()) {
    motion.then.push_back(frames.At(prediction->at_seconds() + horizon.seconds()));
  }
  motion.prediction = *std::move(prediction);
  return motion;
}

absl::Status RunEstimatePicture(const EstimatePictureOptions& options,
                                const GlobalOptions& global) {
  if (absl::Status status = CheckOut(options.out); !status.ok()) return status;
  const auto observation = ObservationFromFile(options.query.files.front(), options.query.source);
  if (!observation.ok()) return observation.status();
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto motion = AskForMotion(*client, options, *observation);
  if (!motion.ok()) return motion.status();
  const auto map = ReadMap(*client, options.query.database, motion->prediction.layer(), "", 0);
  if (!map.ok()) return map.status();
  const auto bones = ReadBones(*client, options.query.database);
  if (!bones.ok()) return bones.status();
  return WriteOut(
      options.out,
      EstimatePicture(*map, *motion, ShortName(options.query.database), options.map, *bones),
      global);
}

// ---- recognize ----------------------------------------------------------------------------------

struct RecognizePictureOptions {
  QueryOptions query;
  std::vector<int> layers;
  double window_seconds = 0.4;
  double hop_seconds = 0.1;
  std::string out;
};

void DeclareRecognizePicture(CLI::App& command, RecognizePictureOptions& options) {
  AddQueryOptionsOfOneFile(command, options.query);
  command.remove_option(command.get_option("--layer"));
  AddOutOption(command, options.out);
  command
      .add_option("--layers", options.layers,
                  "A panel for each of these layers, from 1; else the bottom, a middle and an "
                  "upper layer")
      ->type_name("N,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->expected(1, 8)
      ->check(PositiveNumber());
  command.add_option("--window", options.window_seconds, "Width of the sliding window")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
  command.add_option("--hop", options.hop_seconds, "Distance between windows")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
}

absl::Status RunRecognizePicture(const RecognizePictureOptions& options,
                                 const GlobalOptions& global) {
  if (absl::Status status = CheckOut(options.out); !status.ok()) return status;
  auto observation = ObservationFromFile(options.query.files.front(), options.query.source);
  if (!observation.ok()) return observation.status();
  v1::RecognizeRequest request;
  SetQuery(options.query, request);
  *request.mutable_observation() = *std::move(observation);
  request.set_window_seconds(options.window_seconds);
  request.set_hop_seconds(options.hop_seconds);
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto picture = AskForProfile(*client, std::move(request), options.layers);
  if (!picture.ok()) return picture.status();
  return WriteOut(options.out, *picture, global);
}

// ---- plan ---------------------------------------------------------------------------------------

struct PlanPictureOptions {
  PlanRequestOptions request;
  std::string out;
};

void DeclarePlanPicture(CLI::App& command, PlanPictureOptions& options) {
  AddPlanRequestOptions(command, options.request);
  AddOutOption(command, options.out);
}

absl::Status RunPlanPicture(const PlanPictureOptions& options, const GlobalOptions& global) {
  if (absl::Status status = CheckOut(options.out); !status.ok()) return status;
  v1::PlanRequest request;
  if (absl::Status status = SetPlanRequest(options.request, request); !status.ok()) return status;
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->Plan(request);
  if (!response.ok()) return response.status();
  return WriteOut(options.out, FloorPlanPicture(request, *response), global);
}

}  // namespace

void AddQueryPictureCommands(CommandLine line) {
  AddCommand<EstimatePictureOptions>(
      line, "estimate", "Draw the node path and the prediction of a motion (Figs. 11, 12)",
      "motiondb picture estimate walks observed.bvh --at 1.2 --out estimate.svg",
      DeclareEstimatePicture, RunEstimatePicture);
  AddCommand<RecognizePictureOptions>(
      line, "recognize", "Draw the generation probability over time (Figs. 13-15)",
      "motiondb picture recognize walks observed.bvh --out recognize.svg\n"
      "motiondb picture recognize walks observed.bvh --layers 16,7 --out answer.png",
      DeclareRecognizePicture, RunRecognizePicture);
  AddCommand<PlanPictureOptions>(
      line, "plan", "Draw a plan seen from above (Fig. 16)",
      "motiondb picture plan walks --goal 2,1,0 --out plan.svg\n"
      "motiondb picture plan walks --goal 2,1,1 --alternatives 3 --out plan.png",
      DeclarePlanPicture, RunPlanPicture);
}

}  // namespace motiondb::client
