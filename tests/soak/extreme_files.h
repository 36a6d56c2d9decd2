// Motion files that are as hard on memory as their format allows: few bytes a frame, rates far from
// any recording, counts that the file does not keep, many names. Valid or not.
#pragma once

#include <random>
#include <string>

namespace motiondb::tests {

struct ExtremeFile {
  std::string name;
  std::string bytes;
  std::string skeleton_name;  // empty where the format has none
  std::string skeleton;
};

// A number from `least` to `most`, every magnitude as likely as the others. REQUIRES 0 < least.
double Magnitude(std::mt19937& random, double least, double most);

// At most about `most_bytes` large.
ExtremeFile MakeExtremeFile(std::mt19937& random, std::size_t most_bytes);

}  // namespace motiondb::tests
