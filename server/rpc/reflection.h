// Whether a server tells what calls it has, by grpc.reflection.v1alpha.
#pragma once

#include <grpcpp/server_builder.h>

namespace motiondb::server {

// To be called before the server is built. gRPC's plugin is the process's: it comes with every
// builder.
void SetReflection(bool on, grpc::ServerBuilder& builder);

}  // namespace motiondb::server
