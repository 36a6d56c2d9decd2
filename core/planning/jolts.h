// Frames of a recording at which a marker jolts as no body does: markers were swapped or
// lost. A plan plays them only where there is no other way. Found when asked for, so the cost
// follows the questions. Thread-compatible; the model must outlive it.
#pragma once

#include <cstdint>
#include <vector>

namespace motiondb::core {

class Model;

class Jolts {
 public:
  // Looks at some thousand frames for what is usual.
  explicit Jolts(const Model& model);

  // Whether the largest jerk of a marker about a frame is more than twice what
  // it is in 99 of 100 frames, in leg lengths. O(markers), the first time.
  bool At(int frame);
  // At any of the frames first ... last, which are of one clip.
  bool Within(int first, int last);

 private:
  enum class Known : std::uint8_t { kNo, kSmooth, kJolt };
  float Jerk(int frame) const;

  const Model& model_;
  float limit_ = 0;
  std::vector<Known> known_;
};

}  // namespace motiondb::core
