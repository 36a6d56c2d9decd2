// The parts of a C3D file other than its frames: number formats, parameters and markers.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/error.h"

namespace motiondb::core {

// The bytes of a C3D file, in the number format of the processor that wrote them: Intel (PC), DEC
// (VAX) or MIPS (SGI). Offsets are from the start of the file. A view: the caller keeps the bytes.

inline constexpr std::size_t kC3dBlock = 512;  // bytes

enum class C3dProcessor { kIntel = 84, kDec = 85, kMips = 86 };

class C3dBytes {
 public:
  C3dBytes(SourceFile file, C3dProcessor processor) : file_(file), processor_(processor) {}

  std::size_t size() const { return file_.bytes.size(); }

  // Returns OK if `count` bytes exist from `offset`; otherwise an error with their meaning, `what`.
  absl::Status Require(std::size_t offset, std::size_t count, std::string_view what) const;

  // REQUIRES, for the functions below: the bytes exist.
  std::uint8_t Byte(std::size_t offset) const;
  int SignedByte(std::size_t offset) const;
  std::uint16_t Word(std::size_t offset) const;
  std::int16_t SignedWord(std::size_t offset) const;
  float Real(std::size_t offset) const;  // may be NaN or infinite
  std::string_view Text(std::size_t offset, std::size_t count) const;

  // "walk.c3d: byte 512: ..."
  template <typename... Args>
  absl::Status Error(std::size_t offset, fmt::format_string<Args...> format, Args&&... args) const {
    return InvalidArgument("{}: byte {}: {}", file_.name, offset,
                           fmt::format(format, std::forward<Args>(args)...));
  }

 private:
  SourceFile file_;
  C3dProcessor processor_;
};

// The parameter section of a C3D file: named values in named groups, such as POINT:RATE.
// Immutable after Read; a view on the file's bytes, which the caller keeps.
class C3dParameters {
 public:
  // Reads the section that starts at the byte offset `start` and ends before `end`.
  static absl::StatusOr<C3dParameters> Read(const C3dBytes& bytes, std::size_t start,
                                            std::size_t end);

  // Returns the element of a numeric parameter; nothing if it does not exist. Integers count as
  // unsigned, 0 to 65535, as in files with more than 32767 frames. Names are in upper case.
  std::optional<double> Number(const std::string& group, const std::string& name,
                               std::size_t element = 0) const;

  // Maximum number of strings, and of points, in a file.
  static constexpr std::size_t kMaxStrings = 65'535;
  // Returns the strings of a text parameter, trimmed, at most kMaxStrings; empty if there is none.
  std::vector<std::string_view> Strings(const std::string& group, const std::string& name) const;

 private:
  enum class Type { kText = -1, kByte = 1, kWord = 2, kReal = 4 };
  struct Parameter {
    Type type;
    std::vector<std::size_t> dimensions;  // the first varies fastest
    std::size_t count;                    // number of elements
    std::size_t offset;                   // of the first element
  };

  explicit C3dParameters(const C3dBytes& bytes) : bytes_(bytes) {}
  static absl::StatusOr<Parameter> ReadParameter(const C3dBytes& bytes, std::size_t offset,
                                                 std::string_view name);
  static std::size_t EndOf(const Parameter& parameter);
  const Parameter* Find(const std::string& group, const std::string& name) const;

  C3dBytes bytes_;
  std::map<std::pair<std::string, std::string>, Parameter> parameters_;  // by group and name
};

// Returns the metres per unit of POINT:UNITS, in any case, with the names of units in English,
// German, French, Italian, Spanish and Portuguese, and without regard to brackets and dots: "mm",
// "[cm]", "in.", "Millimètres". Nothing if the unit is unknown or empty.
std::optional<double> MetresPerC3dUnit(std::string_view text);

// A point of a C3D file that is a marker.
struct C3dMarker {
  std::size_t point = 0;  // index in the points of a frame
  std::string name;       // unique UTF-8
};

// Returns the markers among the first `points` points, named by POINT:LABELS, LABELS2 and so on.
// Excludes points listed in POINT:ANGLES, FORCES, MOMENTS, POWERS or SCALARS: they are not
// positions. Removes a "subject:" prefix that all labels share. Appends changes to `notes`.
std::vector<C3dMarker> C3dMarkers(const C3dParameters& parameters, int points,
                                  std::vector<std::string>& notes);

}  // namespace motiondb::core
