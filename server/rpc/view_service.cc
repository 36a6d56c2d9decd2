#include <algorithm>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/model/even_spread.h"
#include "core/motion/error.h"
#include "core/view/node_summary.h"
#include "motiondb/v1/view.grpc.pb.h"
#include "server/engine/query/clip_motion.h"
#include "server/rpc/model_lookup.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"
#include "server/translate/view_message.h"

namespace motiondb::server {
namespace {

constexpr int kViewBlockBytes = 1 << 20;

absl::Status GetFigure(const Call& call, const v1::GetFigureRequest& request,
                       v1::GetFigureResponse& response) {
  const bool is_clip = request.name().find("/clips") != std::string::npos;
  if (!is_clip) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("name", request.name()));
    MOTIONDB_ASSIGN_OR_RETURN(const Figure figure,
                              DatabaseFigure(call.engine, id, call.work_options()));
    SetFigure(figure, *response.mutable_figure());
    return absl::OkStatus();
  }
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseClipName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto clip, call.engine.store().GetClip(id.database, id.id));
  MOTIONDB_ASSIGN_OR_RETURN(const Figure figure,
                            ClipFigure(call.engine, clip, call.work_options()));
  SetFigure(figure, *response.mutable_figure());
  return absl::OkStatus();
}

// The frames first, first + stride, ... of a clip.
struct FrameRange {
  int first = 0;
  int count = 0;
  int stride = 1;
};

absl::StatusOr<FrameRange> ParseRange(const v1::ReadClipMotionRequest& request, int clip_frames) {
  if (request.first_frame() < 0 || request.first_frame() >= clip_frames) {
    return FieldViolation("first_frame", "expected 0 to {}, the last frame of the clip, got {}",
                          clip_frames - 1, request.first_frame());
  }
  if (request.frame_count() < 0) {
    return FieldViolation("frame_count", "expected at least 0, got {}", request.frame_count());
  }
  if (request.stride() < 0) {
    return FieldViolation("stride", "expected at least 0, got {}", request.stride());
  }
  const int stride = std::max(1, request.stride());
  const int all = (clip_frames - 1 - request.first_frame()) / stride + 1;
  const int count = request.frame_count() == 0 ? all : std::min(all, request.frame_count());
  return FrameRange{request.first_frame(), count, stride};
}

absl::StatusOr<MessageSource<v1::ReadClipMotionResponse>> OpenClipMotion(
    const Call& call, const v1::ReadClipMotionRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseClipName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto clip, call.engine.store().GetClip(id.database, id.id));
  MOTIONDB_RETURN_IF_ERROR(ParseRange(request, clip.frame_count).status());
  MOTIONDB_ASSIGN_OR_RETURN(
      ClipMotion read, ReadClipMotion(call.engine, clip, request.joints(), call.work_options()));
  // The clip may have been replaced since.
  MOTIONDB_ASSIGN_OR_RETURN(FrameRange rest, ParseRange(request, read.frame_count()));
  const auto motion = std::make_shared<const ClipMotion>(std::move(read));
  const Eigen::Index numbers =
      motion->markers_m.cols() + motion->joints_m.cols() + motion->joint_rotations.cols();
  const auto frame_bytes = static_cast<std::size_t>(4 * numbers + 1);
  MOTIONDB_RETURN_IF_ERROR(
      call.entry.ReserveFile(frame_bytes * static_cast<std::size_t>(motion->frame_count())));
  return [motion, rest, frame_bytes,
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

// The messages of one map.
class MapSource {
 public:
  // `clip`: index in the model, or -1. `points`: frames of the model.
  MapSource(SnapshotPointer snapshot, std::shared_ptr<const core::StateAxes> axes, int layer,
            int clip, std::vector<int> points)
      : snapshot_(std::move(snapshot)),
        axes_(std::move(axes)),
        layer_(layer),
        nodes_(NodesOf(snapshot_->model, layer, clip)),
        transitions_(snapshot_->model, layer, clip),
        points_(std::move(points)),
        summaries_(snapshot_->model, *axes_) {}
  MapSource(const MapSource&) = delete;
  MapSource& operator=(const MapSource&) = delete;

  // Sets the next message; false at the end.
  bool Next(v1::ReadStateMapResponse& message) {
    const core::Model& model = snapshot_->model;
    if (!begun_) {
      begun_ = true;
      v1::StateMapHeader& header = *message.mutable_header();
      SetMapHeader(*snapshot_, *axes_, layer_, header);
      header.set_node_count(static_cast<int>(nodes_.size()));
      header.set_transition_count(transitions_.edge_count());
      header.set_point_count(static_cast<int>(points_.size()));
      return true;
    }
    if (const auto nodes = TakeNodes(model); !nodes.empty()) {
      AddNodes(model, summaries_, layer_, nodes, *message.mutable_nodes());
      return true;
    }
    constexpr int kMaxEdgeBytes = 5 + 5 + 4;
    const int end =
        std::min(transitions_.edge_count(), edge_ + kViewBlockBytes / kMaxEdgeBytes / 2);
    if (edge_ < end) {
      AddTransitions(transitions_, edge_, end, *message.mutable_transitions());
      edge_ = end;
      return true;
    }
    constexpr std::size_t kMaxPointBytes = 3 * 5 + 12;
    const auto points = std::span(points_).subspan(
        point_, std::min(points_.size() - point_, kViewBlockBytes / kMaxPointBytes / 2));
    point_ += points.size();
    if (points.empty()) return false;
    AddPoints(model, *axes_, layer_, points, *message.mutable_points());
    return true;
  }

 private:
  static std::vector<int> NodesOf(const core::Model& model, int layer, int clip) {
    if (clip >= 0) return model.clip_graph(layer, clip)->nodes;
    std::vector<int> nodes(static_cast<std::size_t>(model.tree().node_count(layer)));
    std::iota(nodes.begin(), nodes.end(), 0);
    return nodes;
  }

  // Takes the next nodes: few enough for a message, with so few frames that a step stays short.
  std::span<const int> TakeNodes(const core::Model& model) {
    constexpr std::size_t kMaxNodes = 8192;  // of at most 72 bytes
    constexpr int kMaxFrames = 1 << 17;
    const std::size_t first = node_;
    int frames = 0;
    while (node_ < nodes_.size() && node_ - first < kMaxNodes && frames < kMaxFrames) {
      const core::Branch& branch =
          model.tree().branches()[model.tree().branch(layer_, nodes_[node_++])];
      frames += branch.end - branch.begin;
    }
    return std::span(nodes_).subspan(first, node_ - first);
  }

  const SnapshotPointer snapshot_;
  const std::shared_ptr<const core::StateAxes> axes_;
  const int layer_;
  const std::vector<int> nodes_;
  const TransitionList transitions_;
  const std::vector<int> points_;
  core::NodeSummaries summaries_;
  bool begun_ = false;
  std::size_t node_ = 0;
  int edge_ = 0;
  std::size_t point_ = 0;
};

constexpr int kMaxPoints = 100'000;

absl::StatusOr<int> ParseLayer(const core::Model& model, int requested) {
  const auto layer = model.ResolveLayer(requested);
  if (!layer.ok()) return AtField("layer", layer.status());
  return *layer;
}

absl::StatusOr<MessageSource<v1::ReadStateMapResponse>> OpenStateMap(
    const Call& call, const v1::ReadStateMapRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const ModelId id, ParseModelName("parent", request.parent()));
  if (request.max_points() < 0) {
    return FieldViolation("max_points", "expected at least 0, got {}", request.max_points());
  }
  MOTIONDB_ASSIGN_OR_RETURN(const SnapshotPointer snapshot, FindReadable(call, id));
  const core::Model& model = snapshot->model;
  MOTIONDB_ASSIGN_OR_RETURN(const int layer, ParseLayer(model, request.layer()));
  MOTIONDB_ASSIGN_OR_RETURN(const int clip, ClipIndex(request.clip(), id, *snapshot));
  MOTIONDB_ASSIGN_OR_RETURN(
      auto axes, snapshot->view->Axes(model, call.engine.workers().Parallel(Pool::kRequests),
                                      call.work_options()));
  const int first = clip < 0 ? 0 : model.clips()[clip].first_frame;
  const int frames = clip < 0 ? model.frame_count() : model.clips()[clip].frame_count;
  std::vector<int> points = core::SpreadEvenly(frames, std::min(request.max_points(), kMaxPoints));
  for (int& point : points) point += first;
  const auto map =
      std::make_shared<MapSource>(snapshot, std::move(axes), layer, clip, std::move(points));
  return [map](v1::ReadStateMapResponse& message) -> absl::StatusOr<bool> {
    return map->Next(message);
  };
}

absl::Status GetNodePoses(const Call& call, const v1::GetNodePosesRequest& request,
                          v1::GetNodePosesResponse& response) {
  constexpr int kMaxPoses = 1000;
  constexpr int kMaxMarkers = 128 * 1024;  // 3 MiB
  MOTIONDB_ASSIGN_OR_RETURN(const ModelId id, ParseModelName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const SnapshotPointer snapshot, FindReadable(call, id));
  const core::Model& model = snapshot->model;
  MOTIONDB_ASSIGN_OR_RETURN(const int layer, ParseLayer(model, request.layer()));
  const int markers = model.marker_set().marker_count();
  const int max_nodes = std::min(kMaxPoses, kMaxMarkers / markers);
  if (request.node_ids().empty() || request.node_ids_size() > max_nodes) {
    return FieldViolation("node_ids", "expected 1 to {} nodes of {} markers, got {}", max_nodes,
                          markers, request.node_ids_size());
  }
  response.set_layer(layer);
  for (const int node : request.node_ids()) {
    const int count = model.tree().node_count(layer);
    if (node < 0 || node >= count) {
      return FieldViolation("node_ids", "expected 0 to {}, the last node of layer {}, got {}",
                            count - 1, layer, node);
    }
    SetNodePose(node, core::MeanPoseOf(model, layer, node), *response.add_poses());
  }
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
