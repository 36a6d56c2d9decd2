// Clients that load a server over the Connect protocol (HTTP/1.1, one connection each).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "motiondb/v1/query.pb.h"
#include "tests/bench/client_load.h"

namespace motiondb::tests {

enum class ConnectCodec { kProtobuf, kJson };

// As NewRecognizeClient, over the HTTP API at `url`, http://HOST:PORT. Each call serializes its
// request and parses its answer, as gRPC does. Returns a client whose calls fail if it cannot
// connect.
std::unique_ptr<LoadClient> NewConnectClient(const std::string& url, ConnectCodec codec,
                                             const std::vector<v1::RecognizeRequest>& requests,
                                             std::size_t first);

}  // namespace motiondb::tests
