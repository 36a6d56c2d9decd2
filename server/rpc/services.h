// Factories of the services of motiondb.v1. A service only translates between messages and the
// engine. It must outlive its grpc::Server; the engine must outlive the service.
#pragma once

#include <grpcpp/impl/service_type.h>
#include <grpcpp/support/server_callback.h>

#include <memory>

#include "server/rpc/call.h"
#include "server/rpc/call_context.h"

namespace motiondb::v1 {
class IngestClipRequest;
class IngestClipResponse;
class ImportDatabaseRequest;
class ImportDatabaseResponse;
class UploadClipRequest;
class UploadClipResponse;
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
std::unique_ptr<grpc::Service> MakeViewService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeOperationService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeQueryService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeObserveService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeAccessService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeStoreService(ServiceContext& host);
std::unique_ptr<grpc::Service> MakeServerService(ServiceContext& host);

// Reactors of the calls with special handling: IngestClip, RestoreStore and ImportDatabase (a file
// in blocks), UploadClip (may wait for motiondb-import), Observe, and WaitOperation (waits without
// a thread). gRPC owns them; they delete themselves in OnDone.

grpc::ServerReadReactor<v1::IngestClipRequest>* NewIngestReactor(
    ServiceContext& host, grpc::CallbackServerContext& context, v1::IngestClipResponse& response);

grpc::ServerUnaryReactor* NewUploadClipReactor(ServiceContext& host,
                                               grpc::CallbackServerContext& context,
                                               const v1::UploadClipRequest& request,
                                               v1::UploadClipResponse& response);

grpc::ServerReadReactor<v1::RestoreStoreRequest>* NewRestoreReactor(
    ServiceContext& host, grpc::CallbackServerContext& context, v1::RestoreStoreResponse& response);

grpc::ServerReadReactor<v1::ImportDatabaseRequest>* NewImportDatabaseReactor(
    ServiceContext& host, grpc::CallbackServerContext& context,
    v1::ImportDatabaseResponse& response);

grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse>* NewObserveReactor(
    ServiceContext& host, grpc::CallbackServerContext& context);

grpc::ServerUnaryReactor* NewWaitReactor(ServiceContext& host, grpc::CallbackServerContext& context,
                                         const v1::WaitOperationRequest& request,
                                         v1::WaitOperationResponse& response);

}  // namespace motiondb::server
