// Clients that act like people and robots. Each is a loop that runs in its own thread until `over`
// is set. They share one tally.
#pragma once

#include <atomic>
#include <mutex>
#include <set>
#include <string>

#include "motiondb/client.h"
#include "motiondb/v1/observation.pb.h"
#include "tests/soak/tally.h"

namespace motiondb::tests {

// The shared state of a soak's clients.
struct Soak {
  std::string address;
  std::atomic<bool> over = false;
  Tally tally;
  v1::MarkerObservation walk;  // on the markers of the database `soak`

  std::mutex mutex;
  std::set<std::string> clips;  // acknowledged and not deleted, by resource name
};

// Returns a new client for one thread.
client::Client Connect(const Soak& soak);

// Creates the database with its first clips, and `walk`. Throws std::runtime_error.
void Prepare(Soak& soak);

// Ingests a figure every 0.5 s; deletes the oldest if there are more than 40.
void IngestAndDelete(Soak& soak);
// Sends the four queries in turn.
void SendAllQueries(Soak& soak, unsigned seed);
// Observes a walk for some seconds at 60 frames per second, repeatedly.
void Watch(Soak& soak, unsigned seed);
// Creates, fills, lists and deletes databases.
void Administer(Soak& soak);
// Runs all functions of broken_clients.h repeatedly.
void Misbehave(Soak& soak, unsigned seed);

}  // namespace motiondb::tests
