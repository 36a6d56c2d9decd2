// Random masks of a model's clips.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <vector>

#include "core/model/clip_mask.h"

namespace motiondb::tests {

inline std::shared_ptr<const core::ClipMask> MaskOf(const core::Model& model,
                                                    std::vector<bool> allowed) {
  auto mask = core::ClipMask::Create(model, std::move(allowed));
  INFO(mask.status());
  REQUIRE(mask.ok());
  return *std::move(mask);
}

// Allows `count` clips.
inline std::shared_ptr<const core::ClipMask> SomeClips(const core::Model& model, int count,
                                                       unsigned seed) {
  std::vector<int> order = core::AllowedClips(model, nullptr);
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  std::vector<bool> allowed(order.size());
  for (int i = 0; i < count; ++i) allowed[order[i]] = true;
  return MaskOf(model, std::move(allowed));
}

}  // namespace motiondb::tests
