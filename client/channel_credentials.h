// How a channel is secured, as ClientOptions say. Safe to call from any thread.
#pragma once

#include <grpcpp/security/credentials.h>
#include <motiondb/client_options.h>

#include <memory>

#include "absl/status/statusor.h"

namespace motiondb::client {

// INVALID_ARGUMENT: options that contradict each other, a file that cannot be read (named), or a
// token that would go over plain text to another machine.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> CredentialsFor(
    const ClientOptions& options);

}  // namespace motiondb::client
