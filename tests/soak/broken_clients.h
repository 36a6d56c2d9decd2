// Clients that misbehave. Nothing that they do may harm the server or another client. Each function
// may be called by many threads.
#pragma once

#include <cstdint>
#include <random>
#include <string>

#include "motiondb/client.h"
#include "tests/soak/tally.h"

namespace motiondb::tests {

// Connects and sends what no gRPC client would: nothing, noise, half of HTTP/2's greeting, a
// greeting with frames of noise; and goes away, now or a while later.
void SendNoise(const std::string& address, std::mt19937& random);

// An ingest of bytes that are no motion, or of a file that stops in the middle.
void IngestGarbage(const client::Client& client, std::mt19937& random, Tally& tally);

// Questions that cannot be answered: of databases and clips that are not there, out of range, NaN.
void AskNonsense(const client::Client& client, std::mt19937& random, Tally& tally);

// A stream that sends and never reads, and then goes away without a word.
void ObserveWithoutReading(const client::Client& client, const std::string& database,
                           const std::string& positions, int frame_count, int marker_count,
                           double seconds);

}  // namespace motiondb::tests
