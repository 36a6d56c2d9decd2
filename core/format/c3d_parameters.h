// The parameter section of a C3D file: named values in named groups, such as POINT:RATE.
// Immutable after Read; a view on the file's bytes, which the caller keeps.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/c3d_bytes.h"

namespace motiondb::core {

class C3dParameters {
 public:
  // Reads the section that starts at the byte offset `start` and ends before `end`.
  static absl::StatusOr<C3dParameters> Read(const C3dBytes& bytes, std::size_t start,
                                            std::size_t end);

  // The element of a numeric parameter; nothing if there is none. Whole numbers count from 0 to
  // 65535, as files with more than 32767 frames have them. Names are in upper case.
  std::optional<double> Number(const std::string& group, const std::string& name,
                               std::size_t element = 0) const;

  // As many strings, and points, as a file can name.
  static constexpr std::size_t kMostStrings = 65'535;
  // The strings of a text parameter, trimmed, at most kMostStrings; empty if there is none.
  std::vector<std::string_view> Strings(const std::string& group, const std::string& name) const;

 private:
  enum class Type { kText = -1, kByte = 1, kWord = 2, kReal = 4 };
  struct Parameter {
    Type type;
    std::vector<std::size_t> dimensions;  // the first varies fastest
    std::size_t count;                    // of elements
    std::size_t offset;                   // of the first
  };

  explicit C3dParameters(const C3dBytes& bytes) : bytes_(bytes) {}
  static absl::StatusOr<Parameter> ReadParameter(const C3dBytes& bytes, std::size_t offset,
                                                 std::string_view name);
  static std::size_t EndOf(const Parameter& parameter);
  const Parameter* Find(const std::string& group, const std::string& name) const;

  C3dBytes bytes_;
  std::map<std::pair<std::string, std::string>, Parameter> parameters_;  // by group and name
};

}  // namespace motiondb::core
