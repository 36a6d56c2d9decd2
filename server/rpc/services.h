// Factories of the services of motiondb.v1. A service only translates between messages and the
// engine. It must outlive its grpc::Server; the engine must outlive the service.
#pragma once

#include <grpcpp/impl/service_type.h>
#include <grpcpp/support/server_callback.h>

#include <memory>

#include "server/rpc/call.h"
#include "server/rpc/service_context.h"

namespace motiondb::v1 {
class IngestClipRequest;
class IngestClipResponse;
class RestoreStoreRequest;
class RestoreStoreResponse;
class ObserveRequest;
class ObserveResponse;
class WaitOperationRequest;
class WaitOperationResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

std::unique_ptr<grpc::Service> MakeDatabaseService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeMarkerSetService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeClipService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeSegmentService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeEditService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeModelService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeOperationService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeQueryService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeObserveService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeAccessService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeStoreService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeServerService(ServiceContext& host);

// Reactors of the calls with special handling: IngestClip and RestoreStore (a file in blocks),
// Observe, and WaitOperation (waits without a thread). gRPC owns them; they delete themselves in
// OnDone.

grpc::ServerReadReactor<v1::IngestClipRequest>* NewIngestReactor(
    ServiceContext& host, grpc::CallbackServerContext& context, v1::IngestClipResponse& response);

grpc::ServerReadReactor<v1::RestoreStoreRequest>* NewRestoreReactor(
    ServiceContext& host, grpc::CallbackServerContext& context, v1::RestoreStoreResponse& response);

grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse>* NewObserveReactor(
    ServiceContext& host, grpc::CallbackServerContext& context);

grpc::ServerUnaryReactor* NewWaitReactor(ServiceContext& host, grpc::CallbackServerContext& context,
                                         const v1::WaitOperationRequest& request,
                                         v1::WaitOperationResponse& response);

}  // namespace motiondb::server
