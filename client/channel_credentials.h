// Credentials of a channel, from ClientOptions.
#pragma once

#include <grpcpp/security/credentials.h>
#include <motiondb/client_options.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::client {

// `addresses`: those in options.server. INVALID_ARGUMENT: contradictory options, an unreadable
// file, or a token that would be sent in plain text to another machine.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> CredentialsFor(
    const ClientOptions& options, const std::vector<std::string>& addresses);

}  // namespace motiondb::client
