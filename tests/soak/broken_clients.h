// Misbehaving clients. They must not harm the server or other clients. Thread-safe.
#pragma once

#include <cstdint>
#include <random>
#include <string>

#include "motiondb/client.h"
#include "tests/soak/tally.h"

namespace motiondb::tests {

// Connects and sends what no gRPC client sends: nothing, noise, half of the HTTP/2 preface, or a
// preface with random frames. Disconnects immediately or later.
void SendNoise(const std::string& address, std::mt19937& random);

// Ingests bytes that are no motion, or a truncated file.
void IngestGarbage(const client::Client& client, std::mt19937& random, Tally& tally);

// Sends invalid queries: unknown databases and clips, out of range, NaN.
void SendInvalidQueries(const client::Client& client, std::mt19937& random, Tally& tally);

// Opens a stream that sends, never reads, and then cancels.
void ObserveWithoutReading(const client::Client& client, const std::string& database,
                           const std::string& positions, int frame_count, int marker_count,
                           double seconds);

}  // namespace motiondb::tests
