// The inner loops of alignment. Results are bitwise identical on all processors
// (core/tree/vectors.h).
#pragma once

namespace motiondb::core {

// Number of observed frames in a block, one per vector lane.
inline constexpr int kFrameLanes = 16;

// Writes the squared distances of observed frames (at most kFrameLanes) from `rows` (count x
// dimensions) to `squared` (frames x count, with `stride` numbers from row to row). `observed` is
// dimensions x kFrameLanes, zero in lanes without a frame. The norms are squared norms.
void SquaredDistances(const float* rows, const float* squared_norms, int count, int dimensions,
                      const float* observed, const float* observed_norms, int frames,
                      float* squared, int stride);

// As above, for one frame: observed (dimensions), squared (count).
void SquaredDistancesOfOne(const float* rows, const float* squared_norms, int count, int dimensions,
                           const float* observed, float observed_norm, float* squared);

// Returns the minimum of the numbers. REQUIRES: count >= 1, no NaN.
float Minimum(const float* numbers, int count);

// Writes max(exp((nearest - squared) * scale), exp(-80)) to `roots` (count). `nearest`: the minimum
// of `squared`, so the roots are at most 1. Returns the maximum of `squared`.
float Roots(const float* squared, int count, float nearest, float scale, float* roots);

// Computes next[z] = (stay ending[z + 2] + go ending[z + 1] + skip ending[z]) roots[z]^4 for z <
// count. Returns the sum.
double Advance(const double* ending, const float* roots, int count, double stay, double go,
               double skip, double* next);

// Extends the cheapest paths by one observed frame. A path arrives at z < count from z (stays) or
// z - 2 (skips), at the extra cost `warp`, or from z - 1. `cost` and `start`: of the paths that end
// at z, after two unreachable ones of infinite cost. Writes next_cost[z], with squared[z] added,
// and the start of that path.
void ExtendCheapest(const float* cost, const int* start, const float* squared, int count,
                    float warp, float* next_cost, int* next_start);

}  // namespace motiondb::core
