// Calls that use as much server memory as the contract allows, generated from a seed: every kind of
// observation, with options at and beyond their limits.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <string>

#include "motiondb/client.h"

namespace motiondb::tests {

struct ExtremeCall {
  std::string kind;       // for reports: "Recognize of slow.bvh"
  std::int64_t size = 0;  // decompressed bytes of the request plus stored bytes that it refers to
  std::function<absl::Status(const client::Client&)> send;
};

// Resources that calls refer to.
struct ExtremeSubject {
  std::string database;  // its name, with a model
  std::string sink;      // a database for ingested clips
  std::string clip;      // name of a stored clip
  std::int64_t clip_bytes = 0;
  std::int64_t database_bytes = 0;
  int marker_count = 0;
};

// `max_bytes`: approximate size of the largest call.
ExtremeCall MakeExtremeCall(std::mt19937& random, const ExtremeSubject& subject,
                            std::size_t max_bytes);

}  // namespace motiondb::tests
