#include <algorithm>
#include <memory>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/view.grpc.pb.h"
#include "server/engine/query/clip_motion.h"
#include "server/engine/query/model_query.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/translate/model_message.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

constexpr int kViewBlockBytes = 1 << 20;

absl::StatusOr<Figure> FindFigure(const Call& call, const std::string& name) {
  if (name.find("/clips") == std::string::npos) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("name", name));
    return DatabaseFigure(call.engine, id, call.work_options());
  }
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseClipName("name", name));
  return ClipFigure(call.engine, id.database, id.id, call.work_options());
}

absl::Status GetFigure(const Call& call, const v1::GetFigureRequest& request,
                       v1::GetFigureResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const Figure figure, FindFigure(call, request.name()));
  SetFigure(figure, *response.mutable_figure());
  return absl::OkStatus();
}

absl::StatusOr<MessageSource<v1::ReadClipMotionResponse>> OpenClipMotion(
    const Call& call, const v1::ReadClipMotionRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseClipName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(
      ClipMotion read,
      ReadClipMotion(call.engine, id.database, id.id,
                     {request.first_frame(), request.frame_count(), request.stride()},
                     request.joints(), call.work_options()));
  const auto motion = std::make_shared<const ClipMotion>(std::move(read));
  const Eigen::Index numbers =
      motion->markers_m.cols() + motion->joints_m.cols() + motion->joint_rotations.cols();
  const auto frame_bytes = static_cast<std::size_t>(4 * numbers + 1);
  MOTIONDB_RETURN_IF_ERROR(
      call.entry.ReserveFile(frame_bytes * static_cast<std::size_t>(motion->frame_count())));
  return [motion, rest = motion->requested, frame_bytes,
          begun = false](v1::ReadClipMotionResponse& message) mutable -> absl::StatusOr<bool> {
    if (rest.count == 0) return false;
    if (!begun) {
      SetFigure(motion->figure, *message.mutable_figure());
      message.set_frame_rate_hz(motion->frame_rate_hz);
      message.set_clip_frame_count(motion->frame_count());
    }
    begun = true;
    constexpr std::size_t kOtherFields = 128;
    const std::size_t used = message.ByteSizeLong() + kOtherFields;
    const std::size_t free = kViewBlockBytes - std::min<std::size_t>(kViewBlockBytes, used);
    const int count = std::min(rest.count, std::max(1, static_cast<int>(free / frame_bytes)));
    SetClipFrames(*motion, rest.first, count, rest.stride, message);
    rest.count -= count;
    if (rest.count > 0) rest.first += count * rest.stride;
    return true;
  };
}

// Sets the next message of a map; false at the end.
bool SetNextPart(StateMap& map, v1::ReadStateMapResponse& message) {
  constexpr std::size_t kMaxNodes = 8192;  // of at most 72 bytes
  constexpr int kMaxEdgeBytes = 5 + 5 + 4;
  constexpr std::size_t kMaxPointBytes = 3 * 5 + 12;
  if (const auto nodes = map.TakeNodes(kMaxNodes); !nodes.empty()) {
    AddNodes(map, nodes, *message.mutable_nodes());
    return true;
  }
  const auto [first, end] = map.TakeTransitions(kViewBlockBytes / kMaxEdgeBytes / 2);
  if (first < end) {
    AddTransitions(map, first, end, *message.mutable_transitions());
    return true;
  }
  const auto points = map.TakePoints(kViewBlockBytes / kMaxPointBytes / 2);
  if (points.empty()) return false;
  AddPoints(map, points, *message.mutable_points());
  return true;
}

absl::StatusOr<MessageSource<v1::ReadStateMapResponse>> OpenStateMap(
    const Call& call, const v1::ReadStateMapRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const ModelId id, ParseModelName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string clip, ParseClipIn(id.database, request.clip()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto map, StateMap::Open(call.engine, {id.database, id.version, request.layer(), clip},
                                     request.max_points(), call.work_options()));
  return [map, begun = false](v1::ReadStateMapResponse& message) mutable -> absl::StatusOr<bool> {
    if (begun) return SetNextPart(*map, message);
    begun = true;
    SetMapHeader(*map, *message.mutable_header());
    return true;
  };
}

absl::Status GetNodePoses(const Call& call, const v1::GetNodePosesRequest& request,
                          v1::GetNodePosesResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const ModelId id, ParseModelName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const NodePoses poses,
      ReadNodePoses(call.engine, {id.database, id.version, request.layer()},
                    {request.node_ids().data(), static_cast<std::size_t>(request.node_ids_size())},
                    call.work_options()));
  SetNodePoses(poses, response);
  return absl::OkStatus();
}

class ViewServiceImpl final : public v1::ViewService::CallbackService {
 public:
  explicit ViewServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerUnaryReactor* GetFigure(grpc::CallbackServerContext* context,
                                      const v1::GetFigureRequest* request,
                                      v1::GetFigureResponse* response) override {
    return Answer<server::GetFigure>(host_, context, request, response);
  }
  grpc::ServerWriteReactor<v1::ReadClipMotionResponse>* ReadClipMotion(
      grpc::CallbackServerContext* context, const v1::ReadClipMotionRequest* request) override {
    return new StreamReactor<v1::ReadClipMotionRequest, v1::ReadClipMotionResponse>(
        host_, context, request, OpenClipMotion);
  }
  grpc::ServerWriteReactor<v1::ReadStateMapResponse>* ReadStateMap(
      grpc::CallbackServerContext* context, const v1::ReadStateMapRequest* request) override {
    return new StreamReactor<v1::ReadStateMapRequest, v1::ReadStateMapResponse>(
        host_, context, request, OpenStateMap);
  }
  grpc::ServerUnaryReactor* GetNodePoses(grpc::CallbackServerContext* context,
                                         const v1::GetNodePosesRequest* request,
                                         v1::GetNodePosesResponse* response) override {
    return Answer<server::GetNodePoses>(host_, context, request, response);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeViewService(ServiceContext& host) {
  return std::make_unique<ViewServiceImpl>(host);
}

}  // namespace motiondb::server
