// Motion files, valid or not, that use as much memory as their format allows: few bytes per frame,
// extreme frame rates, false counts, many names.
#pragma once

#include <random>
#include <string>

namespace motiondb::tests {

struct ExtremeFile {
  std::string name;
  std::string bytes;
  std::string skeleton_name;  // empty if the format has none
  std::string skeleton;
};

// Returns a log-uniform number from `min` to `max`. REQUIRES 0 < least.
double Magnitude(std::mt19937& random, double min, double max);

// Returns a file of at most about `max_bytes`.
ExtremeFile MakeExtremeFile(std::mt19937& random, std::size_t max_bytes);

}  // namespace motiondb::tests
