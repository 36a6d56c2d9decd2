// The inner loops of alignment: the same bits on every processor (core/tree/vectors.h). Safe to
// call from any thread.
#pragma once

namespace motiondb::core {

// Observed frames that are compared at a time: one a lane.
inline constexpr int kFrameLanes = 16;

// squared (frames x count, `stride` numbers apart): squared distances of observed frames (at most
// kFrameLanes) to `rows` (count x dimensions). `observed` is dimensions x kFrameLanes, with zeros
// in lanes without a frame; squared norms of both are given.
void SquaredDistances(const float* rows, const float* squared_norms, int count, int dimensions,
                      const float* observed, const float* observed_norms, int frames,
                      float* squared, int stride);

// The same of one frame: `observed` and `squared` have its numbers alone.
void SquaredDistancesOfOne(const float* rows, const float* squared_norms, int count, int dimensions,
                           const float* observed, float observed_norm, float* squared);

// The least of the numbers (count, at least one, none NaN).
float Least(const float* numbers, int count);

// roots (count): exp((nearest - squared) * scale), but not less than exp(-80). Not more than 1:
// `nearest` is the least of `squared`. Returns the greatest of `squared`.
float Roots(const float* squared, int count, float nearest, float scale, float* roots);

// next[z] = (stay ending[z + 2] + go ending[z + 1] + skip ending[z]) roots[z]^4, z < count. Returns
// their sum.
double Advance(const double* ending, const float* roots, int count, double stay, double go,
               double skip, double* next);

}  // namespace motiondb::core
