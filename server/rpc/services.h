// The services of motiondb.v1. Each translates between messages and the engine, and no more; each
// is owned by the caller and must outlive the grpc::Server that it is registered with, as the
// engine must outlive it.
#pragma once

#include <grpcpp/impl/service_type.h>

#include <memory>

#include "server/engine/engine.h"

namespace motiondb::server {

std::unique_ptr<grpc::Service> MakeDatabaseService(Engine& engine);
std::unique_ptr<grpc::Service> MakeClipService(Engine& engine);
std::unique_ptr<grpc::Service> MakeModelService(Engine& engine);
std::unique_ptr<grpc::Service> MakeOperationService(Engine& engine);
std::unique_ptr<grpc::Service> MakeQueryService(Engine& engine);

}  // namespace motiondb::server
