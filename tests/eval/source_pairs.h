// Clips that exist in two sources: one motion as AMC, and as BVH of another skeleton.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

struct SourcePair {
  std::array<std::unique_ptr<EvalClip>, 2> clips;  // AMC, BVH
};

// Returns the pairs of formats/pairs.tsv with these labels, with the states that a database stores.
// NOT_FOUND or INVALID_ARGUMENT names the missing or invalid file.
absl::StatusOr<std::vector<SourcePair>> LoadSourcePairs(const std::filesystem::path& data,
                                                        double frame_rate_hz,
                                                        const std::vector<std::string>& labels,
                                                        const core::ParallelFor& parallel);

// Returns a clip with the states that a database stores.
absl::StatusOr<EvalClip> LoadStored(const std::filesystem::path& data, double frame_rate_hz,
                                    EvalClip clip);

}  // namespace motiondb::tests
