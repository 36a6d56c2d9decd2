#include "client/cli/picture/picture_geometry.h"

#include <fmt/format.h>
#include <motiondb/v1/view.pb.h>

#include <cstdint>
#include <utility>

#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

std::string CurrentModel(const std::string& database) {
  return DatabaseName(database) + "/models/current";
}

}  // namespace

absl::StatusOr<StateMap> ReadMap(const Client& client, const std::string& database, int layer,
                                 const std::string& clip, int points) {
  v1::ReadStateMapRequest request;
  request.set_parent(CurrentModel(database));
  if (layer > 0) request.set_layer(layer);
  request.set_clip(clip);
  request.set_max_points(points);
  StateMap map;
  absl::Status status = client.ReadStateMap(
      request, [&](const v1::ReadStateMapResponse& part) { return map.Add(part); });
  if (!status.ok()) return status;
  return map;
}

absl::StatusOr<Bones> ReadBones(const Client& client, const std::string& database) {
  v1::GetFigureRequest request;
  request.set_name(DatabaseName(database));
  const auto response = client.GetFigure(request);
  if (!response.ok()) return response.status();
  return MarkerBones(response->figure());
}

absl::StatusOr<std::vector<MeanPose>> ReadMeanPoses(const Client& client,
                                                    const std::string& database, int layer,
                                                    const std::vector<int>& node_ids) {
  std::vector<MeanPose> poses;
  if (node_ids.empty()) return poses;
  v1::GetNodePosesRequest request;
  request.set_parent(CurrentModel(database));
  request.set_layer(layer);
  for (const int id : node_ids) request.add_node_ids(id);
  const auto response = client.GetNodePoses(request);
  if (!response.ok()) return response.status();
  for (const v1::NodePose& pose : response->poses()) {
    poses.push_back(
        {UnpackFloats(pose.marker_positions()), UnpackFloats(pose.marker_velocities())});
  }
  if (poses.size() != node_ids.size()) {
    return absl::DataLossError(
        fmt::format("the server sent {} poses of {} nodes", poses.size(), node_ids.size()));
  }
  return poses;
}

namespace {

// A frame of a clip, and what the clip has.
struct ClipFrame {
  Pose positions;
  double frame_rate_hz = 0;
  int frame_count = 0;  // of the clip
};

absl::StatusOr<ClipFrame> ReadClipFrame(const Client& client, const std::string& clip, int frame) {
  v1::ReadClipMotionRequest request;
  request.set_name(clip);
  request.set_first_frame(frame);
  request.set_frame_count(1);
  ClipFrame read;
  absl::Status status =
      client.ReadClipMotion(request, [&](const v1::ReadClipMotionResponse& block) {
        if (block.clip_frame_count() > 0) read.frame_count = block.clip_frame_count();
        if (block.frame_rate_hz() > 0) read.frame_rate_hz = block.frame_rate_hz();
        if (block.frame_count() > 0) read.positions = UnpackFloats(block.marker_positions());
        return absl::OkStatus();
      });
  if (!status.ok()) return status;
  if (read.frame_count == 0 || read.frame_rate_hz == 0 || read.positions.empty()) {
    return absl::DataLossError(
        fmt::format("the server sent no frame {} of clip {}", frame, ShortName(clip)));
  }
  return read;
}

}  // namespace

absl::StatusOr<std::vector<ClipMoment>> ReadMoments(const Client& client, const std::string& clip,
                                                    int count) {
  std::vector<ClipMoment> moments;
  int last_frame = 0;
  for (int i = 0; i < count; ++i) {
    const int frame = count > 1 ? static_cast<int>(std::int64_t{last_frame} * i / (count - 1)) : 0;
    auto read = ReadClipFrame(client, clip, frame);
    if (!read.ok()) return read.status();
    if (i == 0) last_frame = read->frame_count - 1;
    moments.push_back({frame / read->frame_rate_hz, std::move(read->positions)});
  }
  return moments;
}

}  // namespace motiondb::client
