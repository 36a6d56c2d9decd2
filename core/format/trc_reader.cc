#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/format/conventions.h"
#include "core/format/readers.h"
#include "core/format/text_scanner.h"

namespace motiondb::core {
namespace {

constexpr int kMaxFileMarkers = 65'535;  // as in C3D
constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

std::string_view Trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\v\f");
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\v\f") - first + 1);
}

// The cells of one line: separated by tabs, possibly empty; or words, if the line has no tab.
class Cells {
 public:
  explicit Cells(std::string_view line) : rest_(line), tabs_(line.find('\t') != line.npos) {}

  // Returns the next cell, trimmed; nothing after the last.
  std::optional<std::string_view> Next() {
    if (!tabs_) rest_ = Trimmed(rest_);
    if (done_ || (!tabs_ && rest_.empty())) return std::nullopt;
    const std::size_t length = std::min(rest_.find(tabs_ ? '\t' : ' '), rest_.size());
    const std::string_view cell = rest_.substr(0, length);
    done_ = length == rest_.size();
    rest_.remove_prefix(done_ ? length : length + 1);
    return Trimmed(cell);
  }

  // Returns the next cell; empty after the last.
  std::string_view NextOrEmpty() { return Next().value_or(std::string_view()); }

 private:
  std::string_view rest_;
  bool tabs_;
  bool done_ = false;
};

struct TrcHeader {
  double rate_hz = 0;
  int frames = 0;
  int markers = 0;
  std::string_view unit;
};

class TrcReader {
 public:
  explicit TrcReader(SourceFile file) : scanner_(file) {}

  absl::Status Read() {
    MOTIONDB_RETURN_IF_ERROR(ReadHeader());
    MOTIONDB_RETURN_IF_ERROR(ReadNames());
    MOTIONDB_RETURN_IF_ERROR(ReadRows());
    if (auto note = NoteOnFileEnd(scanner_)) notes_.push_back(*std::move(note));
    return absl::OkStatus();
  }

  const TrcHeader& header() const { return header_; }
  std::vector<std::string>& names() { return names_; }
  std::vector<std::string>& notes() { return notes_; }
  FrameMatrix positions() const {
    return Eigen::Map<const FrameMatrix>(values_.data(), header_.frames, 3 * header_.markers);
  }

 private:
  absl::Status ReadHeader() {
    MOTIONDB_RETURN_IF_ERROR(scanner_.ReadKeyword("pathfiletype"));
    scanner_.Line();
    Cells keys(scanner_.Line());
    if (!scanner_.SkipBlankLines())
      return scanner_.Expected("the values of DataRate, NumFrames ...", "");
    Cells values(scanner_.Line());
    std::optional<double> rate;
    std::optional<double> frames;
    std::optional<double> markers;
    for (auto key = keys.Next(); key; key = keys.Next()) {
      const std::string_view value = values.NextOrEmpty();
      if (IsKeyword(*key, "datarate")) rate = ParseNumber(value);
      if (IsKeyword(*key, "numframes")) frames = ParseNumber(value);
      if (IsKeyword(*key, "nummarkers")) markers = ParseNumber(value);
      if (IsKeyword(*key, "units")) header_.unit = value;
    }
    if (!rate || !IsFrameRate(*rate)) {
      return scanner_.Error("expected a DataRate from 0.001 to 100000 Hz{}", Found(rate));
    }
    header_.rate_hz = *rate;
    MOTIONDB_RETURN_IF_ERROR(TakeCount("NumFrames", frames, header_.frames));
    MOTIONDB_RETURN_IF_ERROR(TakeCount("NumMarkers", markers, header_.markers));
    if (header_.markers > kMaxFileMarkers) {
      return scanner_.Error("expected NumMarkers to be at most {}, found {}", kMaxFileMarkers,
                            header_.markers);
    }
    return absl::OkStatus();
  }

  static std::string Found(std::optional<double> value) {
    return value ? fmt::format(", found {}", *value) : "";
  }

  absl::Status TakeCount(std::string_view what, std::optional<double> value, int& count) const {
    constexpr double kMaxCount = std::numeric_limits<int>::max() / 3.0;
    if (!value || *value < 1 || *value > kMaxCount || *value != std::floor(*value)) {
      return scanner_.Error("expected {} to be a whole number from 1{}", what, Found(value));
    }
    count = static_cast<int>(*value);
    return absl::OkStatus();
  }

  // Reads "Frame#", "Time", then a name for every three columns; and the line X1, Y1, Z1 ... below.
  absl::Status ReadNames() {
    if (!scanner_.SkipBlankLines()) return scanner_.Expected("the line of marker names", "");
    Cells cells(scanner_.Line());
    const std::string_view first = cells.NextOrEmpty();
    if (!IsKeyword(first, "frame#")) return scanner_.Expected("'Frame#'", first);
    const std::string_view second = cells.NextOrEmpty();
    if (!IsKeyword(second, "time")) return scanner_.Expected("'Time'", second);
    UniqueNames unique;
    // One extra name is enough to report the mismatch.
    for (auto cell = cells.Next(); cell && std::ssize(names_) <= header_.markers;
         cell = cells.Next()) {
      if (!cell->empty()) names_.push_back(unique.Add(*cell));
    }
    if (std::string note = unique.Note(); !note.empty()) notes_.push_back(std::move(note));
    if (static_cast<int>(names_.size()) != header_.markers) {
      return scanner_.Error("expected {} marker names, as in NumMarkers, found {}", header_.markers,
                            names_.size());
    }
    if (!scanner_.SkipBlankLines()) return scanner_.Expected("the line of X1, Y1, Z1 ...", "");
    const std::string_view axes = Trimmed(scanner_.PeekLine());
    if (axes[0] == 'X' || axes[0] == 'x') scanner_.Line();
    return absl::OkStatus();
  }

  absl::Status ReadRows() {
    const auto width = 3 * static_cast<std::size_t>(header_.markers);
    // A row has at least two digits and one tab for each cell: this bounds the allocation.
    const std::size_t max_rows = scanner_.bytes_left() / (width + 2) + 1;
    values_.reserve(width *
                    std::min<std::size_t>(max_rows, static_cast<std::size_t>(header_.frames)));
    for (int frame = 0; frame < header_.frames; ++frame) {
      if (!scanner_.SkipBlankLines()) {
        return scanner_.Error("the file ends here (truncated?), expected {} frames, found {}",
                              header_.frames, frame);
      }
      MOTIONDB_RETURN_IF_ERROR(ReadRow(frame));
    }
    if (!scanner_.AtEnd()) {
      return scanner_.Error("expected the file to end after {} frames, as in NumFrames",
                            header_.frames);
    }
    const double span = time_ - first_time_;
    const double expected = (header_.frames - 1) / header_.rate_hz;
    if (std::abs(span - expected) > 0.01 * expected + 0.5 / header_.rate_hz) {
      notes_.push_back(fmt::format(
          "the time column spans {:.4g} s, DataRate implies {:.4g} s and is used", span, expected));
    }
    return absl::OkStatus();
  }

  absl::Status ReadRow(int frame) {
    Cells cells(scanner_.Line());
    const std::string_view number_cell = cells.NextOrEmpty();
    const std::optional<double> number = ParseNumber(number_cell);
    if (!number || (frame > 0 && *number != number_ + 1)) {
      return ExpectedCell(frame == 0 ? "a frame number" : fmt::format("frame {}", number_ + 1),
                          number_cell);
    }
    if (frame == 0 && *number != 1) notes_.push_back(fmt::format("frames start at {}", *number));
    number_ = *number;

    const std::string_view time_cell = cells.NextOrEmpty();
    const std::optional<double> time = ParseNumber(time_cell);
    if (!time) return ExpectedCell("a time in seconds", time_cell);
    if (frame > 0 && !(*time > time_)) {
      return scanner_.Error("expected a time after {} s in frame {}, found {} s", time_, number_,
                            *time);
    }
    if (frame == 0) first_time_ = *time;
    time_ = *time;

    for (const std::string& name : names_) MOTIONDB_RETURN_IF_ERROR(ReadMarker(name, cells));
    for (auto cell = cells.Next(); cell; cell = cells.Next()) {
      if (!cell->empty()) {
        return scanner_.Error("expected {} markers in frame {}, found '{}' after them",
                              header_.markers, number_, Shown(*cell));
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadMarker(const std::string& name, Cells& cells) {
    int missing = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const std::optional<std::string_view> cell = cells.Next();
      if (!cell) {
        return scanner_.Error("the line ends early (truncated?), expected {} of marker '{}'",
                              "xyz"[axis], name);
      }
      if (cell->empty() || IsKeyword(*cell, "nan")) {
        ++missing;
        values_.push_back(kMissing);
      } else if (const std::optional<double> value = ParseNumber(*cell)) {
        values_.push_back(static_cast<float>(*value));
      } else {
        return scanner_.Expected(fmt::format("{} of marker '{}'", "xyz"[axis], name), *cell);
      }
    }
    if (missing == 0 || missing == 3) return absl::OkStatus();
    return scanner_.Error("expected all three coordinates of marker '{}' or none, found {}", name,
                          3 - missing);
  }

  absl::Status ExpectedCell(std::string_view what, std::string_view found) const {
    return found.empty() ? scanner_.Error("expected {}, found an empty cell", what)
                         : scanner_.Expected(what, found);
  }

  TextScanner scanner_;
  TrcHeader header_;
  std::vector<std::string> names_;
  std::vector<std::string> notes_;
  std::vector<float> values_;
  double number_ = 0;  // of the last frame read
  double time_ = 0;    // of the last frame read, s
  double first_time_ = 0;
};

}  // namespace

absl::StatusOr<MotionFile> ReadTrc(SourceFile file, const ReadOptions& options) {
  TrcReader reader(file);
  MOTIONDB_RETURN_IF_ERROR(reader.Read());
  const TrcHeader& header = reader.header();
  const std::optional<double> unit = MetresPerUnitNamed(header.unit);
  if (!unit && !options.metres_per_unit) {
    return InvalidArgument("{}:3: expected Units m, cm, mm or in, found '{}'", file.name,
                           Shown(header.unit));
  }
  MotionFile read;
  read.report.notes = std::move(reader.notes());
  FrameMatrix positions = reader.positions();
  DecideUnit({.given = options.metres_per_unit, .stated = unit, .deduced = {}, .fallback = 1},
             read.report);
  DecideUpAxis({.given = options.up_axis,
                .stated = {},
                .deduced = DeduceConventions(reader.names(), positions).up_axis,
                .fallback = UpAxis::kY},
               read.report);
  ToWorld(read.report, positions);
  read.motion = MarkerMotion{.names = std::move(reader.names()),
                             .frame_rate_hz = options.frame_rate_hz.value_or(header.rate_hz),
                             .positions_m = std::move(positions)};
  return read;
}

}  // namespace motiondb::core
