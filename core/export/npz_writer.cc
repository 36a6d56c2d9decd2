#include <fmt/format.h>
#include <zlib.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <variant>
#include <vector>

#include "core/export/writers.h"
#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "text/utf8.h"

namespace motiondb::core {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as they are stored");

constexpr std::uint64_t kMaxArchive = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kNpyAlignment = 64;  // of an array's data, by the .npy format
constexpr int kDate1980 = (1 << 5) | 1;    // 1980-01-01 in MS-DOS format

// Appends the `bytes` low bytes of a value, lowest first.
void PutNpzInteger(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xff);
}

template <typename T>
void PutNpzNumber(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}

std::string NpyHeader(std::string_view type, std::span<const std::size_t> shape) {
  std::string dimensions;
  for (const std::size_t size : shape) dimensions += fmt::format("{},", size);
  std::string text =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, dimensions);
  constexpr std::size_t kPreamble = 10;  // magic, version and length
  const std::size_t unpadded = kPreamble + text.size() + 1;
  text.append((kNpyAlignment - unpadded % kNpyAlignment) % kNpyAlignment, ' ');
  text += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  PutNpzInteger(header, text.size(), 2);
  return header + text;
}

// A zip archive of stored members. Zip needs no library without compression; its checksum is
// zlib's crc32, because Abseil has only the other polynomial (CRC-32C).
class NpzBytes {
 public:
  explicit NpzBytes(std::size_t expected) { out_.reserve(expected); }

  // `put(out)` appends the array's data in C order.
  template <typename Put>
  void Add(std::string_view name, std::string_view type, std::span<const std::size_t> shape,
           const Put& put) {
    Member member{.name = fmt::format("{}.npy", name), .offset = out_.size()};
    out_ += LocalHeader(member);  // replaced when size and checksum are known
    const std::size_t begin = out_.size();
    out_ += NpyHeader(type, shape);
    put(out_);
    member.size = out_.size() - begin;
    member.crc = crc32_z(0, reinterpret_cast<const Bytef*>(out_.data() + begin), member.size);
    const std::string header = LocalHeader(member);
    out_.replace(member.offset, header.size(), header);
    members_.push_back(std::move(member));
  }

  // Returns the archive, which is longer than 4 GiB if it is not valid.
  std::string Finish() {
    const std::size_t begin = out_.size();
    for (const Member& member : members_) {
      out_.append("PK\x01\x02", 4);
      PutNpzInteger(out_, kZipVersion, 2);
      out_ += CommonFields(member);
      out_.append(10, '\0');  // comment, disk, attributes
      PutNpzInteger(out_, member.offset, 4);
      out_ += member.name;
    }
    const std::size_t directory = out_.size() - begin;
    out_.append("PK\x05\x06", 4);
    PutNpzInteger(out_, 0, 4);  // disks
    PutNpzInteger(out_, members_.size(), 2);
    PutNpzInteger(out_, members_.size(), 2);
    PutNpzInteger(out_, directory, 4);
    PutNpzInteger(out_, begin, 4);
    PutNpzInteger(out_, 0, 2);  // comment
    return std::move(out_);
  }

 private:
  static constexpr int kZipVersion = 20;

  struct Member {
    std::string name;
    std::size_t offset = 0;
    std::size_t size = 0;
    std::uint64_t crc = 0;
  };

  static std::string LocalHeader(const Member& member) {
    return "PK\x03\x04" + CommonFields(member) + member.name;
  }

  static std::string CommonFields(const Member& member) {
    std::string fields;
    PutNpzInteger(fields, kZipVersion, 2);
    PutNpzInteger(fields, 0, 2);  // flags
    PutNpzInteger(fields, 0, 2);  // stored
    PutNpzInteger(fields, 0, 2);  // time
    PutNpzInteger(fields, kDate1980, 2);
    PutNpzInteger(fields, member.crc, 4);
    PutNpzInteger(fields, member.size, 4);
    PutNpzInteger(fields, member.size, 4);
    PutNpzInteger(fields, member.name.size(), 2);
    PutNpzInteger(fields, 0, 2);  // extra fields
    return fields;
  }

  std::string out_;
  std::vector<Member> members_;
};

void AddVersionAndRate(NpzBytes& archive, double frame_rate_hz) {
  archive.Add("motiondb_version", "<i4", {},
              [&](std::string& out) { PutNpzNumber(out, std::int32_t{kNpzVersion}); });
  archive.Add("frame_rate_hz", "<f8", {},
              [&](std::string& out) { PutNpzNumber(out, frame_rate_hz); });
}

std::u32string NpzCharacters(std::string_view utf8) {
  std::u32string characters;
  while (!utf8.empty()) {
    const text::Character character = text::FirstCharacter(utf8);
    characters += character.code;
    utf8.remove_prefix(character.bytes);
  }
  return characters;
}

void AddNpzNames(NpzBytes& archive, std::string_view name, const std::vector<std::string>& names) {
  std::vector<std::u32string> texts;
  std::size_t width = 1;
  for (const std::string& text : names) {
    texts.push_back(NpzCharacters(ToUtf8(text)));
    width = std::max(width, texts.back().size());
  }
  const std::size_t shape[] = {names.size()};
  archive.Add(name, fmt::format("<U{}", width), shape, [&](std::string& out) {
    for (std::u32string& text : texts) {
      text.resize(width);
      for (const char32_t character : text) PutNpzInteger(out, character, 4);
    }
  });
}

// About the bytes of an archive besides its large arrays; it grows for many names.
constexpr std::size_t kNpzOverhead = 4096;

absl::Status CheckNpzSize(Eigen::Index frames, std::size_t points, std::size_t numbers_per_point) {
  const double bytes = static_cast<double>(frames) * static_cast<double>(points) *
                       static_cast<double>(numbers_per_point) * sizeof(double);
  if (bytes < static_cast<double>(kMaxArchive)) return absl::OkStatus();
  return InvalidArgument("NPZ: {} frames of {} points exceed the 4 GiB of an archive", frames,
                         points);
}

absl::Status CheckNpzNames(const std::vector<std::string>& names) {
  std::unordered_set<std::string> seen;
  for (const std::string& name : names) {
    if (!seen.insert(ToUtf8(name)).second) {
      return InvalidArgument("NPZ: two points are named '{}'", Shown(name));
    }
  }
  return absl::OkStatus();
}

// Positions and rotations of all joints in all frames, in the parents' frames and the world.
struct NpzPoses {
  std::vector<double> rotations;          // x y z w
  std::vector<double> local_positions_m;  // x y z
  std::vector<double> positions_m;        // x y z
};

// Sets `rotation` to the quaternion of the matrix with w >= 0; false if it is not a rotation.
bool ToNpzQuaternion(const Eigen::Matrix3d& matrix, Eigen::Quaterniond& rotation) {
  constexpr double kMaxSkew = 1e-6;
  if (!(matrix.transpose() * matrix).isIdentity(kMaxSkew) || !(matrix.determinant() > 0)) {
    return false;
  }
  rotation = Eigen::Quaterniond(matrix).normalized();
  if (rotation.w() < 0) rotation.coeffs() *= -1;
  return true;
}

absl::StatusOr<NpzPoses> PoseNpzJoints(const JointMotion& motion) {
  const Skeleton& skeleton = *motion.skeleton;
  const std::size_t joints = skeleton.joints().size();
  const std::size_t total = joints * static_cast<std::size_t>(motion.angles.rows());
  NpzPoses posed;
  posed.rotations.reserve(4 * total);
  posed.local_positions_m.reserve(3 * total);
  posed.positions_m.reserve(3 * total);
  std::vector<Eigen::Quaterniond> previous(joints, Eigen::Quaterniond::Identity());
  std::vector<Eigen::Isometry3d> world(joints);
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    const double* row = motion.angles.data() + frame * motion.angles.cols();
    for (std::size_t j = 0; j < joints; ++j) {
      const Joint& joint = skeleton.joints()[j];
      const Eigen::Isometry3d local = ParentFromJoint(
          joint, {row + skeleton.first_dof(static_cast<int>(j)), joint.dofs.size()});
      world[j] = joint.parent < 0 ? local : world[joint.parent] * local;
      Eigen::Quaterniond rotation;
      if (!ToNpzQuaternion(local.linear(), rotation)) {
        return InvalidArgument("NPZ: the transform of joint '{}' is not a rotation in frame {}",
                               Shown(joint.name), frame);
      }
      if (rotation.dot(previous[j]) < 0) rotation.coeffs() *= -1;
      previous[j] = rotation;
      posed.rotations.insert(posed.rotations.end(), rotation.coeffs().begin(),
                             rotation.coeffs().end());
      const Eigen::Vector3d from = local.translation();
      posed.local_positions_m.insert(posed.local_positions_m.end(), from.begin(), from.end());
      const Eigen::Vector3d at = world[j].translation();
      posed.positions_m.insert(posed.positions_m.end(), at.begin(), at.end());
    }
  }
  return posed;
}

void AddNpzNumbers(NpzBytes& archive, std::string_view name, std::span<const std::size_t> shape,
                   std::span<const double> numbers) {
  archive.Add(name, "<f8", shape, [&](std::string& out) {
    out.append(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes());
  });
}

absl::StatusOr<std::string> WriteNpzJoints(const JointMotion& motion) {
  constexpr std::size_t kNumbersPerJoint = 10;
  MOTIONDB_RETURN_IF_ERROR(CheckWritable("NPZ", motion));
  const std::vector<Joint>& joints = motion.skeleton->joints();
  std::vector<std::string> names;
  names.reserve(joints.size());
  for (const Joint& joint : joints) names.push_back(joint.name);
  MOTIONDB_RETURN_IF_ERROR(CheckNpzNames(names));
  MOTIONDB_RETURN_IF_ERROR(CheckNpzSize(motion.angles.rows(), joints.size(), kNumbersPerJoint));
  MOTIONDB_ASSIGN_OR_RETURN(const NpzPoses posed, PoseNpzJoints(motion));

  const auto frames = static_cast<std::size_t>(motion.angles.rows());
  NpzBytes archive(frames * joints.size() * kNumbersPerJoint * sizeof(double) + kNpzOverhead);
  AddVersionAndRate(archive, motion.frame_rate_hz);
  AddNpzNames(archive, "joint_names", names);
  const std::size_t vector_of_joints[] = {joints.size()};
  archive.Add("parents", "<i4", vector_of_joints, [&](std::string& out) {
    for (const Joint& joint : joints) PutNpzNumber(out, static_cast<std::int32_t>(joint.parent));
  });
  const std::size_t rest[] = {joints.size(), 3};
  archive.Add("offsets_m", "<f8", rest, [&](std::string& out) {
    for (const Joint& joint : joints) {
      for (const double value : joint.offset_m) PutNpzNumber(out, value);
    }
  });
  const std::size_t rest_quaternions[] = {joints.size(), 4};
  archive.Add("rest_rotations", "<f8", rest_quaternions, [&](std::string& out) {
    for (const Joint& joint : joints) {
      Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
      ToNpzQuaternion(joint.pre_rotation * joint.post_rotation, rotation);
      for (const double value : rotation.coeffs()) PutNpzNumber(out, value);
    }
  });
  const std::size_t quaternions[] = {frames, joints.size(), 4};
  const std::size_t positions[] = {frames, joints.size(), 3};
  AddNpzNumbers(archive, "local_rotations", quaternions, posed.rotations);
  AddNpzNumbers(archive, "local_positions_m", positions, posed.local_positions_m);
  AddNpzNumbers(archive, "positions_m", positions, posed.positions_m);
  return archive.Finish();
}

absl::StatusOr<std::string> WriteNpzMarkers(const MarkerMotion& motion) {
  MOTIONDB_RETURN_IF_ERROR(CheckWritable("NPZ", motion));
  MOTIONDB_RETURN_IF_ERROR(CheckNpzNames(motion.names));
  const FrameMatrix& positions = motion.positions_m;
  MOTIONDB_RETURN_IF_ERROR(CheckNpzSize(positions.rows(), motion.names.size(), 3));
  NpzBytes archive(static_cast<std::size_t>(positions.size()) * sizeof(double) + kNpzOverhead);
  AddVersionAndRate(archive, motion.frame_rate_hz);
  AddNpzNames(archive, "marker_names", motion.names);
  const std::size_t shape[] = {static_cast<std::size_t>(positions.rows()), motion.names.size(), 3};
  archive.Add("positions_m", "<f8", shape, [&](std::string& out) {
    for (Eigen::Index i = 0; i < positions.size(); ++i) {
      PutNpzNumber(out, static_cast<double>(positions.data()[i]));
    }
  });
  return archive.Finish();
}

}  // namespace

absl::StatusOr<std::string> WriteNpz(const Motion& motion) {
  const auto* joints = std::get_if<JointMotion>(&motion);
  MOTIONDB_ASSIGN_OR_RETURN(
      std::string bytes,
      joints ? WriteNpzJoints(*joints) : WriteNpzMarkers(std::get<MarkerMotion>(motion)));
  if (bytes.size() > kMaxArchive) {
    return InvalidArgument("NPZ: {} bytes exceed the 4 GiB of an archive", bytes.size());
  }
  return bytes;
}

}  // namespace motiondb::core
