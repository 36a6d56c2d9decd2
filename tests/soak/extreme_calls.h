// Calls that are as hard on a server's memory as the contract allows, one after the other from a
// seed: every kind of observation with options at their limits and beyond.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <string>

#include "motiondb/client.h"

namespace motiondb::tests {

struct ExtremeCall {
  std::string kind;       // for reports: "Recognize of slow.bvh"
  std::int64_t size = 0;  // decompressed bytes that it sends and stored bytes that it names
  std::function<absl::Status(const client::Client&)> send;
};

// What calls may name.
struct ExtremeSubject {
  std::string database;  // its name, with a model
  std::string sink;      // name of a database that takes clips
  std::string clip;      // name of a stored clip
  std::int64_t clip_bytes = 0;
  std::int64_t database_bytes = 0;
  int marker_count = 0;
};

// `most_bytes`: of the largest call, about.
ExtremeCall MakeExtremeCall(std::mt19937& random, const ExtremeSubject& subject,
                            std::size_t most_bytes);

}  // namespace motiondb::tests
