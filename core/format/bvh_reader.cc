#include <algorithm>
#include <limits>
#include <memory>

#include "core/format/bvh_hierarchy.h"
#include "core/format/conventions.h"
#include "core/format/readers.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

constexpr double kCentimetre = 0.01;

// Destination of a channel's value: column = factor * value + bias.
struct ChannelColumn {
  int column;
  double factor;
  double bias;
};

// Returns the channels of all joints in file order. A skeleton has a joint's translations before
// its rotations; the file may have any order.
std::vector<ChannelColumn> ChannelColumns(const std::vector<BvhJoint>& joints) {
  std::vector<ChannelColumn> columns;
  int first = 0;
  for (const BvhJoint& joint : joints) {
    int translation = first;
    int rotation = first + static_cast<int>(std::count_if(
                               joint.channels.begin(), joint.channels.end(),
                               [](BvhChannel c) { return c.kind == Dof::Kind::kTranslation; }));
    for (const BvhChannel& channel : joint.channels) {
      if (channel.kind == Dof::Kind::kTranslation) {
        columns.push_back({translation++, 1.0, -joint.offset[channel.axis]});
      } else {
        columns.push_back({rotation++, kRadiansPerDegree, 0.0});
      }
    }
    first += static_cast<int>(joint.channels.size());
  }
  return columns;
}

std::vector<Dof> Dofs(const BvhJoint& joint, const Eigen::Matrix3d& axes) {
  std::vector<Dof> dofs;
  for (const Dof::Kind kind : {Dof::Kind::kTranslation, Dof::Kind::kRotation}) {
    for (const BvhChannel& channel : joint.channels) {
      if (channel.kind != kind) continue;
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(channel.axis);
      dofs.push_back({.kind = kind, .axis = unit});
      if (kind == Dof::Kind::kTranslation) dofs.back().axis = axes * unit;
    }
  }
  return dofs;
}

absl::StatusOr<Skeleton> BuildSkeleton(const std::vector<BvhJoint>& joints, double metres_per_unit,
                                       const Eigen::Matrix3d& world_from_file) {
  std::vector<Joint> built;
  for (const BvhJoint& joint : joints) {
    const bool root = joint.parent < 0;
    const Eigen::Matrix3d axes = root ? world_from_file : Eigen::Matrix3d::Identity();
    built.push_back({.name = joint.name,
                     .parent = joint.parent,
                     .offset_m = axes * joint.offset * metres_per_unit,
                     .pre_rotation = axes,
                     .dofs = Dofs(joint, axes)});
  }
  return Skeleton::Create(joints.front().name, std::move(built));
}

absl::Status ReadFrameTime(TextScanner& scanner, std::vector<std::string>& notes, double& rate_hz) {
  std::string_view token = scanner.Token();
  if (IsKeyword(token, "frame")) {
    token = scanner.Token();
    if (!IsKeyword(token, "time")) return scanner.Expected("'Frame Time:'", token);
  } else if (!IsKeyword(token, "frametime")) {
    return scanner.Expected("'Frame Time:'", token);
  }
  MOTIONDB_RETURN_IF_ERROR(scanner.ReadKeyword(":"));
  double seconds = 0;
  MOTIONDB_RETURN_IF_ERROR(scanner.ReadNumber("the frame time in seconds", seconds));
  if (!(seconds > 0) || !IsFrameRate(1 / seconds)) {
    return scanner.Error(
        "expected a frame time above 0 s that is between 1e-5 and 1000 s, found {}", seconds);
  }
  rate_hz = SnapFrameRate(1 / seconds, notes);
  return absl::OkStatus();
}

std::size_t CountNumbers(std::string_view line) {
  TextScanner numbers({.name = "", .bytes = line});
  std::size_t count = 0;
  for (double value = 0; numbers.TryNumber(value);) ++count;
  return count;
}

// Returns the number count of the first line of frames, if it may explain the error.
std::string NumbersOnLine(std::string_view line, std::size_t expected) {
  const std::size_t count = CountNumbers(line);
  if (count == 0 || count == expected) return "";
  return fmt::format(" (the first line of frames has {} numbers, the hierarchy {} channels)", count,
                     expected);
}

// Checks that nothing follows the frames. One extra frame of the same width is allowed: some
// writers count from 0.
absl::Status ReadSurplus(TextScanner& scanner, int frames, std::string_view first_line,
                         std::size_t width, std::vector<std::string>& notes) {
  if (scanner.AtEnd()) return absl::OkStatus();
  const std::string_view line = scanner.Line();
  if (CountNumbers(line) == width && CountNumbers(first_line) == width && scanner.AtEnd()) {
    notes.push_back(fmt::format(
        "the file has one frame more than its {} declared frames; the last frame is ignored",
        frames));
    return absl::OkStatus();
  }
  return scanner.Error("expected the file to end after {} frames, found '{}'{}", frames,
                       Shown(line), NumbersOnLine(first_line, width));
}

std::string NumberOfFrame(std::size_t number, std::size_t width, int frame, int frames) {
  return fmt::format("number {} of {} of frame {} of {}", number, width, frame, frames);
}

absl::StatusOr<JointMatrix> ReadNumbers(TextScanner& scanner, int frames,
                                        const std::vector<ChannelColumn>& columns,
                                        std::vector<std::string>& notes) {
  const std::size_t width = columns.size();
  // A file may declare more frames than it has: allocate by its number of words.
  const std::size_t max_frames = CountWords(scanner.rest()) / width;
  const int allocated =
      static_cast<int>(std::min<std::size_t>(max_frames, static_cast<std::size_t>(frames)));
  JointMatrix values(allocated, static_cast<Eigen::Index>(width));
  scanner.AtEnd();
  const std::string_view first_line = scanner.PeekLine();
  for (int frame = 0; frame < frames; ++frame) {
    if (frame == allocated || scanner.AtEnd()) {
      return scanner.Error("the file ends here (truncated?), expected {} frames, found {}{}",
                           frames, frame, NumbersOnLine(first_line, width));
    }
    double* row = values.data() + frame * values.cols();
    for (const ChannelColumn& column : columns) {
      double value = 0;
      if (!scanner.TryNumber(value)) {
        const auto number = static_cast<std::size_t>(&column - columns.data()) + 1;
        return scanner.Expected(
            NumberOfFrame(number, width, frame + 1, frames) + NumbersOnLine(first_line, width),
            scanner.LastRead());
      }
      row[column.column] = column.factor * value + column.bias;
    }
  }
  MOTIONDB_RETURN_IF_ERROR(ReadSurplus(scanner, frames, first_line, width, notes));
  return values;
}

// Whether each line seems to be one frame; one of the first two lines may be wrong.
bool HasFrameOnEachLine(TextScanner scanner, std::size_t width) {
  if (scanner.AtEnd()) return false;
  if (CountNumbers(scanner.Line()) == width) return true;
  return !scanner.AtEnd() && CountNumbers(scanner.Line()) == width;
}

// Returns the error of the first line that is not one frame.
absl::Status CheckLines(TextScanner scanner, int frames, std::size_t width) {
  for (int frame = 1; frame <= frames && !scanner.AtEnd(); ++frame) {
    double value = 0;
    for (std::size_t number = 1; number <= width; ++number) {
      if (scanner.TryNumberOnLine(value)) continue;
      return scanner.Expected(NumberOfFrame(number, width, frame, frames), scanner.LastRead());
    }
    if (const std::string_view more = scanner.TokenOnLine(); !more.empty()) {
      return scanner.Error("expected {} numbers in frame {} of {}, found '{}' after them", width,
                           frame, frames, Shown(more));
    }
  }
  return absl::OkStatus();
}

// Frames are a stream of numbers; line breaks do not matter. After an error, lines locate it.
absl::StatusOr<JointMatrix> ReadFrames(TextScanner& scanner, int frames,
                                       const std::vector<ChannelColumn>& columns,
                                       std::vector<std::string>& notes) {
  const TextScanner first = scanner;
  auto values = ReadNumbers(scanner, frames, columns, notes);
  if (!values.ok() && HasFrameOnEachLine(first, columns.size())) {
    MOTIONDB_RETURN_IF_ERROR(CheckLines(first, frames, columns.size()));
  }
  return values;
}

// Determines unit and up axis from the joints' positions in frames spread over the clip.
absl::Status DecideConventions(const std::vector<BvhJoint>& joints, const JointMatrix& values,
                               const ReadOptions& options, SourceReport& report) {
  constexpr Eigen::Index kSamples = 32;
  MOTIONDB_ASSIGN_OR_RETURN(Skeleton unscaled,
                            BuildSkeleton(joints, 1, Eigen::Matrix3d::Identity()));
  const Eigen::Index count = std::min(kSamples, values.rows());
  JointMotion sample{.skeleton = std::make_shared<const Skeleton>(std::move(unscaled)),
                     .frame_rate_hz = 1,
                     .angles = JointMatrix(count, values.cols())};
  for (Eigen::Index i = 0; i < count; ++i) {
    sample.angles.row(i) = values.row(i * values.rows() / count);
  }
  // Relative to the root's first position: positions are floats, and files may be far from the
  // origin.
  const std::vector<Dof>& root = sample.skeleton->joints().front().dofs;
  for (std::size_t k = 0; k < root.size() && root[k].kind == Dof::Kind::kTranslation; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    sample.angles.col(column).array() -= values(0, column);
  }
  const FrameMatrix positions = JointPositions(sample);
  std::vector<std::string> names;
  names.reserve(joints.size());
  for (const BvhJoint& joint : joints) names.push_back(joint.name);

  const DeducedConventions deduced = DeduceConventions(names, positions, sample.skeleton.get());
  DecideUnit(options.metres_per_unit, {}, deduced, kCentimetre, report);
  DecideUpAxis(
      {.given = options.up_axis, .stated = {}, .deduced = deduced.up_axis, .fallback = UpAxis::kY},
      report);
  return absl::OkStatus();
}

// Converts translations from the file's unit to metres.
void ScaleTranslations(const Skeleton& skeleton, double metres_per_unit, JointMatrix& values) {
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    int column = skeleton.first_dof(j);
    for (const Dof& dof : skeleton.joints()[j].dofs) {
      if (dof.kind == Dof::Kind::kTranslation) values.col(column) *= metres_per_unit;
      ++column;
    }
  }
}

}  // namespace

absl::StatusOr<MotionFile> ReadBvh(SourceFile file, const ReadOptions& options) {
  TextScanner scanner(file, kBvhPunctuation);
  MotionFile read;
  SourceReport& report = read.report;
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<BvhJoint> joints,
                            ReadBvhHierarchy(scanner, report.notes));
  int frames = 0;
  double rate_hz = 0;
  MOTIONDB_RETURN_IF_ERROR(scanner.ReadKeyword("frames"));
  MOTIONDB_RETURN_IF_ERROR(scanner.ReadKeyword(":"));
  MOTIONDB_RETURN_IF_ERROR(
      scanner.ReadInteger("the number of frames", 1, std::numeric_limits<int>::max(), frames));
  MOTIONDB_RETURN_IF_ERROR(ReadFrameTime(scanner, report.notes, rate_hz));
  MOTIONDB_ASSIGN_OR_RETURN(JointMatrix values,
                            ReadFrames(scanner, frames, ChannelColumns(joints), report.notes));
  if (auto note = NoteOnFileEnd(scanner)) report.notes.push_back(*std::move(note));

  MOTIONDB_RETURN_IF_ERROR(DecideConventions(joints, values, options, report));
  MOTIONDB_ASSIGN_OR_RETURN(Skeleton skeleton, BuildSkeleton(joints, report.metres_per_unit,
                                                             WorldFromFile(report.up_axis)));
  ScaleTranslations(skeleton, report.metres_per_unit, values);
  read.motion = JointMotion{.skeleton = std::make_shared<const Skeleton>(std::move(skeleton)),
                            .frame_rate_hz = options.frame_rate_hz.value_or(rate_hz),
                            .angles = std::move(values)};
  return read;
}

}  // namespace motiondb::core
