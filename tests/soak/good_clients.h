// Clients that do what people and robots do, each a loop that runs until it is told to stop. They
// share one tally. Thread-safe: each loop is for a thread of its own.
#pragma once

#include <atomic>
#include <mutex>
#include <set>
#include <string>

#include "motiondb/client.h"
#include "motiondb/v1/observation.pb.h"
#include "tests/soak/tally.h"

namespace motiondb::tests {

// What a soak's clients share.
struct Soak {
  std::string address;
  std::atomic<bool> over = false;
  Tally tally;
  v1::MarkerObservation walk;  // in the markers of the database `soak`

  std::mutex mutex;
  std::set<std::string> clips;  // that were acknowledged and not deleted, by resource name
};

// A client of its own, for a thread of its own.
client::Client Connect(const Soak& soak);

// The database and its first clips, and `walk`. Throws std::runtime_error.
void Prepare(Soak& soak);

// Ingests a figure every half second, and deletes the oldest of more than 40.
void IngestAndDelete(Soak& soak);
// Asks the four questions, one after the other.
void AskInTurn(Soak& soak, unsigned seed);
// Watches a walk for some seconds, at 60 frames a second, again and again.
void Watch(Soak& soak, unsigned seed);
// Makes databases, fills, lists and deletes them.
void Administer(Soak& soak);
// All that broken_clients.h has, again and again.
void Misbehave(Soak& soak, unsigned seed);

}  // namespace motiondb::tests
