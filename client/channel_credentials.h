// Credentials of a channel, from ClientOptions.
#pragma once

#include <grpcpp/security/credentials.h>
#include <motiondb/client_options.h>

#include <memory>

#include "absl/status/statusor.h"

namespace motiondb::client {

// INVALID_ARGUMENT: contradictory options, an unreadable file, or a token that would be sent in
// plain text to another machine.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> CredentialsFor(
    const ClientOptions& options);

}  // namespace motiondb::client
