// The services of motiondb.v1. Each translates between messages and the engine, and no more; each
// is owned by the caller and must outlive the grpc::Server that it is registered with, as the
// engine must outlive it.
#pragma once

#include <grpcpp/impl/service_type.h>

#include <memory>

#include "server/rpc/call.h"

namespace motiondb::server {

std::unique_ptr<grpc::Service> MakeDatabaseService(CallHost& host);
std::unique_ptr<grpc::Service> MakeClipService(CallHost& host);
std::unique_ptr<grpc::Service> MakeModelService(CallHost& host);
std::unique_ptr<grpc::Service> MakeOperationService(CallHost& host);
std::unique_ptr<grpc::Service> MakeQueryService(CallHost& host);
std::unique_ptr<grpc::Service> MakeObserveService(CallHost& host);
std::unique_ptr<grpc::Service> MakeAccessService(CallHost& host);
std::unique_ptr<grpc::Service> MakeStoreService(CallHost& host);

}  // namespace motiondb::server
