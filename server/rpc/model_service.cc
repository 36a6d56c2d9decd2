#include <algorithm>
#include <charconv>
#include <memory>

#include "core/motion/error.h"
#include "motiondb/v1/model.grpc.pb.h"
#include "server/engine/query/model_query.h"
#include "server/engine/snapshot.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/translate/model_message.h"
#include "server/translate/page.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

absl::Status GetModel(const Call& call, const v1::GetModelRequest& request,
                      v1::GetModelResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const ModelId id, ParseModelName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const ListedModels found,
      DescribeModel(call.engine, id.database, id.version, call.work_options()));
  SetModel(found.records.front(), found.settings, found.current.get(), *response.mutable_model());
  return absl::OkStatus();
}

absl::Status ListModels(const Call& call, const v1::ListModelsRequest& request,
                        v1::ListModelsResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  const std::string scope = fmt::format("{}/models", DatabaseName(id));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string token, DecodePageToken(scope, request.page_token()));
  int before = 0;
  std::from_chars(token.data(), token.data() + token.size(), before);
  MOTIONDB_ASSIGN_OR_RETURN(
      const ListedModels listed,
      ListStoredModels(call.engine, id, before, size + 1, call.work_options()));
  const auto make = [&](const storage::ModelRecord& record, v1::Model& to) {
    SetModel(record, listed.settings, listed.current.get(), to);
  };
  response.set_next_page_token(
      FillPageFrom(listed.records, size, scope, *response.mutable_models(), make,
                   [](const auto& record) { return std::to_string(record.version); }));
  return absl::OkStatus();
}

absl::Status ListNodes(const Call& call, const v1::ListNodesRequest& request,
                       v1::ListNodesResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const ModelId id, ParseModelName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 400));
  const std::string scope =
      fmt::format("{}/models/nodes of layer {}", DatabaseName(id.database), request.layer());
  MOTIONDB_ASSIGN_OR_RETURN(const auto position, DecodeModelPosition(scope, request.page_token()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const ModelLayer found,
      FindLayer(call.engine, {id.database, id.version, request.layer(), "", position.model},
                call.work_options()));
  const core::Model& model = found.model();
  const int count = model.tree().node_count(found.layer) - position.index;
  const int taken = FillPage(count, size, *response.mutable_nodes(), [&](int i, v1::Node& node) {
    SetNode(model, found.layer, position.index + i, node);
  });
  if (taken < count) {
    response.set_next_page_token(
        EncodeModelPosition(scope, {StampOf(*found.snapshot), position.index + taken}));
  }
  return absl::OkStatus();
}

absl::Status ListTransitions(const Call& call, const v1::ListTransitionsRequest& request,
                             v1::ListTransitionsResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const ModelId id, ParseModelName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string clip, ParseClipIn(id.database, request.clip()));
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 1000, 10'000));
  const std::string scope = fmt::format("{}/models/transitions of layer {} of '{}'",
                                        DatabaseName(id.database), request.layer(), request.clip());
  MOTIONDB_ASSIGN_OR_RETURN(const auto position, DecodeModelPosition(scope, request.page_token()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const ModelLayer found,
      FindLayer(call.engine, {id.database, id.version, request.layer(), clip, position.model},
                call.work_options()));
  const TransitionList transitions(found);
  const int count = transitions.edge_count() - position.index;
  const int taken = FillPage(
      count, size, *response.mutable_transitions(),
      [&](int i, v1::Transition& to) { SetTransition(transitions.At(position.index + i), to); });
  if (taken < count) {
    response.set_next_page_token(
        EncodeModelPosition(scope, {StampOf(*found.snapshot), position.index + taken}));
  }
  return absl::OkStatus();
}

absl::StatusOr<MessageSource<v1::ReadStatesResponse>> OpenStates(
    const Call& call, const v1::ReadStatesRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const ModelId id, ParseModelName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const SnapshotPointer snapshot,
      FindReadableModel(call.engine, id.database, id.version, call.work_options()));
  // A frame has its state and its node number, a varint of at most 5 bytes.
  const int frame_bytes = 4 * static_cast<int>(snapshot->model.states().cols()) + 5;
  const int block_frames = std::max(1, (1 << 20) / frame_bytes);
  return [snapshot, block_frames,
          next = 0](v1::ReadStatesResponse& message) mutable -> absl::StatusOr<bool> {
    const int end = std::min(snapshot->model.frame_count(), next + block_frames);
    if (next == end) return false;
    SetStates(snapshot->model, next, end, message);
    next = end;
    return true;
  };
}

class ModelServiceImpl final : public v1::ModelService::CallbackService {
 public:
  explicit ModelServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerUnaryReactor* GetModel(grpc::CallbackServerContext* context,
                                     const v1::GetModelRequest* request,
                                     v1::GetModelResponse* response) override {
    return Answer<server::GetModel>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListModels(grpc::CallbackServerContext* context,
                                       const v1::ListModelsRequest* request,
                                       v1::ListModelsResponse* response) override {
    return Answer<server::ListModels>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListNodes(grpc::CallbackServerContext* context,
                                      const v1::ListNodesRequest* request,
                                      v1::ListNodesResponse* response) override {
    return Answer<server::ListNodes>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListTransitions(grpc::CallbackServerContext* context,
                                            const v1::ListTransitionsRequest* request,
                                            v1::ListTransitionsResponse* response) override {
    return Answer<server::ListTransitions>(host_, context, request, response);
  }
  grpc::ServerWriteReactor<v1::ReadStatesResponse>* ReadStates(
      grpc::CallbackServerContext* context, const v1::ReadStatesRequest* request) override {
    return new StreamReactor<v1::ReadStatesRequest, v1::ReadStatesResponse>(host_, context, request,
                                                                            OpenStates);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeModelService(ServiceContext& host) {
  return std::make_unique<ModelServiceImpl>(host);
}

}  // namespace motiondb::server
