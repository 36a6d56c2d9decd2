// Whether a server tells what calls it has, by grpc.reflection.v1alpha.
#pragma once

namespace motiondb::server {

// For servers whose builder this thread makes from now on. gRPC's plugins are the process's, made
// with each builder.
void SetReflection(bool on);

}  // namespace motiondb::server
