#include <algorithm>
#include <memory>
#include <unordered_map>
#include <utility>

#include "core/format/asf_file.h"
#include "core/format/conventions.h"
#include "core/format/readers.h"
#include "core/format/text_scanner.h"

namespace motiondb::core {
namespace {

constexpr double kMetresPerInch = 0.0254;
constexpr double kDefaultRate = 120;

bool IsFrameNumber(std::string_view word) {
  return !word.empty() && word.find_first_not_of("0123456789") == word.npos;
}

class AmcFramesReader {
 public:
  AmcFramesReader(SourceFile file, const AsfSkeleton& skeleton, bool degrees,
                  double metres_per_unit)
      : scanner_(file),
        skeleton_(skeleton),
        degrees_(degrees),
        metres_per_unit_(metres_per_unit),
        width_(static_cast<std::size_t>(skeleton.skeleton.dof_count())),
        last_frame_(skeleton.bones.size(), 0),
        next_bone_(skeleton.bones.size(), 0) {
    for (std::size_t i = 0; i < skeleton.bones.size(); ++i) {
      index_[skeleton.bones[i].name] = i;
      if (!skeleton.bones[i].values.empty()) ++bones_a_frame_;
    }
  }

  absl::Status Read() {
    MOTIONDB_RETURN_IF_ERROR(ReadHeader());
    MOTIONDB_RETURN_IF_ERROR(ReadFrames());
    if (auto note = NoteOnFileEnd(scanner_)) notes_.push_back(*std::move(note));
    return absl::OkStatus();
  }

  JointMatrix angles() const {
    return Eigen::Map<const JointMatrix>(values_.data(), frames_,
                                         static_cast<Eigen::Index>(width_));
  }
  std::optional<double> rate_hz() const { return rate_hz_; }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  absl::Status ReadHeader() {
    while (scanner_.NextLine('#') && scanner_.PeekLine().starts_with(':')) {
      const std::string_view word = scanner_.TokenOnLine();
      if (IsKeyword(word, ":degrees")) degrees_ = true;
      if (IsKeyword(word, ":radians")) degrees_ = false;
      if (IsKeyword(word, ":samples-per-second")) {
        double rate = 0;
        MOTIONDB_RETURN_IF_ERROR(scanner_.ReadNumber("the samples per second", rate));
        if (!IsFrameRate(rate)) {
          return scanner_.Expected("a rate from 0.001 to 100000 Hz", scanner_.LastRead());
        }
        rate_hz_ = rate;
      }
      scanner_.RestOfLine();
    }
    return absl::OkStatus();
  }

  absl::Status ReadFrames() {
    while (scanner_.NextLine('#')) {
      const std::string_view word = scanner_.TokenOnLine();
      MOTIONDB_RETURN_IF_ERROR(IsFrameNumber(word) ? BeginFrame(word) : ReadBone(word));
    }
    if (frames_ == 0) return scanner_.Expected("the number of the first frame", "");
    return EndFrame("");
  }

  absl::Status BeginFrame(std::string_view word) {
    const std::optional<double> number = ParseNumber(word);
    if (frames_ > 0) MOTIONDB_RETURN_IF_ERROR(EndFrame(word));
    if (!number || (frames_ > 0 && *number != number_ + 1)) {
      return scanner_.Expected(fmt::format("frame {}", number_ + 1), word);
    }
    if (const std::string_view rest = scanner_.RestOfLine(); !rest.empty()) {
      return scanner_.Expected("a frame's number alone on its line", rest);
    }
    if (frames_ == 0 && *number != 1) {
      notes_.push_back(fmt::format("frames start at {:.0f}", *number));
    }
    if (frames_ == 0) bytes_at_first_frame_ = scanner_.bytes_left();
    if (frames_ == 1) ReserveFrames();
    number_ = *number;
    ++frames_;
    bones_read_ = 0;
    values_.resize(values_.size() + width_);
    return absl::OkStatus();
  }

  // Reserves memory for the number of frames estimated from the first frame's length.
  void ReserveFrames() {
    const std::size_t frame_bytes = bytes_at_first_frame_ - scanner_.bytes_left();
    values_.reserve(width_ * (2 + bytes_at_first_frame_ / std::max<std::size_t>(1, frame_bytes)));
  }

  absl::Status EndFrame(std::string_view found) {
    if (bones_read_ == bones_a_frame_) return absl::OkStatus();
    for (std::size_t i = 0; i < skeleton_.bones.size(); ++i) {
      const AmcBone& bone = skeleton_.bones[i];
      if (last_frame_[i] != frames_ && !bone.values.empty()) {
        return scanner_.Expected(fmt::format("bone '{}' in frame {:.0f}", bone.name, number_),
                                 found);
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadBone(std::string_view word) {
    if (frames_ == 0) return scanner_.Expected("the number of the first frame", word);
    MOTIONDB_ASSIGN_OR_RETURN(const std::size_t index, FindBone(word));
    const AmcBone& bone = skeleton_.bones[index];
    if (last_frame_[index] == frames_) {
      return scanner_.Error("expected bone '{}' once in frame {:.0f}, found it twice", bone.name,
                            number_);
    }
    last_frame_[index] = frames_;
    if (!bone.values.empty()) ++bones_read_;
    double* row = values_.data() + values_.size() - width_;
    for (const AmcValue& place : bone.values) {
      double value = 0;
      if (!scanner_.TryNumberOnLine(value)) {
        const std::string_view found = scanner_.LastRead();
        return scanner_.Expected(
            fmt::format("value {} of {} of bone '{}' in frame {:.0f}",
                        &place - bone.values.data() + 1, bone.values.size(), bone.name, number_),
            found);
      }
      if (place.column < 0) continue;
      row[place.column] = value * (!place.is_rotation ? metres_per_unit_
                                   : degrees_         ? kRadiansPerDegree
                                                      : 1);
    }
    if (const std::string_view rest = scanner_.RestOfLine(); !rest.empty()) {
      return scanner_.Expected(fmt::format("{} values of bone '{}' in frame {:.0f}",
                                           bone.values.size(), bone.name, number_),
                               rest);
    }
    return absl::OkStatus();
  }

  // Frames list bones in the same order, so first try the successor in the previous frame.
  absl::StatusOr<std::size_t> FindBone(std::string_view word) {
    const std::size_t guess = next_bone_[previous_bone_];
    if (skeleton_.bones[guess].name == word) return previous_bone_ = guess;
    const auto found = index_.find(ToUtf8(word));
    if (found == index_.end()) {
      return scanner_.Expected(fmt::format("a bone of the skeleton in frame {:.0f}", number_),
                               word);
    }
    next_bone_[previous_bone_] = found->second;
    return previous_bone_ = found->second;
  }

  TextScanner scanner_;
  const AsfSkeleton& skeleton_;
  bool degrees_;
  double metres_per_unit_;
  std::size_t width_;
  std::unordered_map<std::string, std::size_t> index_;
  std::vector<int> last_frame_;         // of each bone: the last frame that has it
  std::vector<std::size_t> next_bone_;  // successor of each bone
  std::size_t previous_bone_ = 0;
  std::size_t bytes_at_first_frame_ = 0;
  int bones_a_frame_ = 0;  // bones with values
  int bones_read_ = 0;     // bones with values in this frame
  int frames_ = 0;
  double number_ = 0;  // of this frame in the file
  std::vector<double> values_;
  std::optional<double> rate_hz_;
  std::vector<std::string> notes_;
};

}  // namespace

absl::StatusOr<MotionFile> ReadAmc(SourceFile file, SourceFile skeleton,
                                   const ReadOptions& options) {
  MOTIONDB_ASSIGN_OR_RETURN(const AsfFile asf, ReadAsf(skeleton));
  MotionFile read;
  SourceReport& report = read.report;
  const auto metres = [](double length_unit) { return kMetresPerInch / length_unit; };
  DecideUnit({.given = options.metres_per_unit,
              .stated = asf.length_unit ? std::optional(metres(*asf.length_unit)) : std::nullopt,
              .deduced = {},
              .fallback = metres(1)},
             report);
  DecideUpAxis(
      {.given = options.up_axis, .stated = UpAxis::kY, .deduced = {}, .fallback = UpAxis::kY},
      report);
  MOTIONDB_ASSIGN_OR_RETURN(AsfSkeleton built, BuildAsfSkeleton(asf, report.metres_per_unit,
                                                                WorldFromFile(report.up_axis)));
  AmcFramesReader frames(file, built, asf.degrees, report.metres_per_unit);
  MOTIONDB_RETURN_IF_ERROR(frames.Read());
  report.notes = frames.notes();
  if (built.drops_stretch) report.notes.push_back("changes of bone length are ignored");
  if (!options.frame_rate_hz && !frames.rate_hz()) {
    report.notes.push_back(
        fmt::format("frame rate {} Hz assumed (the file states none)", kDefaultRate));
  }
  const double rate = frames.rate_hz().value_or(kDefaultRate);
  read.motion = JointMotion{.skeleton = std::make_shared<const Skeleton>(std::move(built.skeleton)),
                            .frame_rate_hz = options.frame_rate_hz.value_or(rate),
                            .angles = frames.angles()};
  return read;
}

}  // namespace motiondb::core
