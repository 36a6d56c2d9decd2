// Packed little-endian float32, as messages hold marker positions and joint angles.
#pragma once

#include <cstring>
#include <string>
#include <vector>

namespace motiondb::tests {

inline std::string Pack(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), sizeof(float) * values.size()};
}

inline std::vector<float> Unpack(const std::string& bytes) {
  std::vector<float> values(bytes.size() / sizeof(float));
  if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), sizeof(float) * values.size());
  return values;
}

}  // namespace motiondb::tests
