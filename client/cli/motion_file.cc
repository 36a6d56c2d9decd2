#include "client/cli/motion_file.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "client/cli/command.h"
#include "client/input_file.h"
#include "text/utf8.h"

namespace motiondb::client {

namespace {

struct KnownFormat {
  std::string_view extension;
  std::string_view name;  // in requests of motiondb-import
  v1::FileFormat format;
  bool is_written;
};

constexpr std::array<KnownFormat, 11> kFormats = {{
    {".bvh", "bvh", v1::FILE_FORMAT_BVH, true},
    {".amc", "amc", v1::FILE_FORMAT_AMC, false},
    {".trc", "trc", v1::FILE_FORMAT_TRC, true},
    {".c3d", "c3d", v1::FILE_FORMAT_C3D, true},
    {".csv", "csv", v1::FILE_FORMAT_CSV, true},
    {".npz", "npz", v1::FILE_FORMAT_NPZ, true},
    {".glb", "gltf", v1::FILE_FORMAT_GLTF, true},
    {".gltf", "gltf", v1::FILE_FORMAT_GLTF, false},
    {".vrm", "gltf", v1::FILE_FORMAT_GLTF, false},
    {".fbx", "fbx", v1::FILE_FORMAT_FBX, false},
    {".dae", "dae", v1::FILE_FORMAT_COLLADA, false},
}};

}  // namespace

std::string MotionExtension(const std::filesystem::path& file) {
  const std::string extension = text::LowerCase(file.extension().string());
  return extension == ".gz" ? text::LowerCase(file.stem().extension().string()) : extension;
}

bool IsMotionFile(const std::filesystem::path& file) {
  return std::ranges::find(kFormats, MotionExtension(file), &KnownFormat::extension) !=
         kFormats.end();
}

std::string MotionExtensions() {
  std::string text;
  for (const KnownFormat& known : kFormats) {
    text += (text.empty() ? "" : ", ") + std::string(known.extension);
  }
  return text;
}

absl::StatusOr<v1::FileFormat> WrittenFormat(const std::string& name) {
  const std::string extension = (name.starts_with('.') ? "" : ".") + text::LowerCase(name);
  const auto* const found = std::ranges::find(kFormats, extension, &KnownFormat::extension);
  if (found != kFormats.end() && found->is_written) return found->format;
  return absl::InvalidArgumentError(
      fmt::format("'{}' is no format that is written; expected {}", name, WrittenFormatNames()));
}

std::string NameOfFormat(v1::FileFormat format) {
  const auto* const found = std::ranges::find(kFormats, format, &KnownFormat::format);
  return found == kFormats.end() ? "" : std::string(found->name);
}

std::string WrittenFormatNames() {
  std::string text;
  for (const KnownFormat& known : kFormats) {
    if (known.is_written)
      text += (text.empty() ? "" : "|") + std::string(known.extension.substr(1));
  }
  return text;
}

namespace {

namespace fs = std::filesystem;

v1::UpAxis UpAxisOf(const std::string& name) {
  if (name == "x") return v1::UP_AXIS_X;
  if (name == "y") return v1::UP_AXIS_Y;
  if (name == "z") return v1::UP_AXIS_Z;
  return v1::UP_AXIS_UNSPECIFIED;
}

}  // namespace

bool HasExtension(const fs::path& file, const std::string& expected) {
  return text::LowerCase(file.extension().string()) == expected;
}

void AddSourceOptions(CLI::App& command, SourceOptions& options) {
  command
      .add_option(
          "--skeleton", options.skeleton,
          "ASF skeleton of AMC files; else the ASF file in the same folder with the longest "
          "name that the AMC name begins with. URDF of a robot's CSV files; else the only one in "
          "the same folder")
      ->type_name("FILE.asf|FILE.urdf");
  command
      .add_option("--take", options.take,
                  "Take of a file with several, by name or by number from 1")
      ->type_name("TAKE");
  command
      .add_option("--metres-per-unit", options.metres_per_unit,
                  "Metres per length unit of the file; else as stated or deduced")
      ->type_name("M")
      ->check(PositiveNumber());
  command
      .add_option("--up-axis", options.up_axis, "Axis that points up; else as stated or deduced")
      ->type_name("x|y|z")
      ->check(CLI::IsMember({"x", "y", "z"}));
  command
      .add_option("--frame-rate", options.frame_rate_hz,
                  "Frame rate of files that do not state it; else 120 for AMC")
      ->type_name("HZ")
      ->check(PositiveNumber());
  command
      .add_option("--leg-length", options.leg_length_m,
                  "The subject's leg length; else measured or estimated")
      ->type_name("M")
      ->check(PositiveNumber());
}

void AddForceOption(CLI::App& command, SourceOptions& options) {
  command.add_flag("--force", options.force,
                   "Accept a body that no person has: its size, or lying throughout");
}

v1::SourceConventions Conventions(const SourceOptions& options) {
  v1::SourceConventions conventions;
  if (options.metres_per_unit > 0) conventions.set_metres_per_unit(options.metres_per_unit);
  conventions.set_up_axis(UpAxisOf(options.up_axis));
  if (options.frame_rate_hz > 0) conventions.set_frame_rate_hz(options.frame_rate_hz);
  if (options.leg_length_m > 0) conventions.set_leg_length_m(options.leg_length_m);
  conventions.set_force(options.force);
  conventions.set_take(options.take);
  return conventions;
}

namespace {

fs::path FolderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// Returns nothing if there is none, or more than one.
fs::path OnlyUrdfBeside(const fs::path& csv) {
  fs::path only;
  std::error_code error;
  for (fs::directory_iterator entry(FolderOf(csv), error), end; !error && entry != end;
       entry.increment(error)) {
    if (MotionExtension(entry->path()) != ".urdf") continue;
    if (!only.empty()) return {};
    only = entry->path();
  }
  return only;
}

}  // namespace

absl::StatusOr<fs::path> FindSkeletonBeside(const fs::path& amc) {
  const fs::path folder = FolderOf(amc);
  const std::string name = amc.stem().string();
  fs::path best;
  std::size_t best_length = 0;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path& candidate = entry->path();
    if (MotionExtension(candidate) != ".asf") continue;
    const fs::path plain = HasExtension(candidate, ".gz") ? candidate.stem() : candidate;
    const std::string stem = plain.stem().string();
    if (name.rfind(stem, 0) != 0 || stem.size() <= best_length) continue;
    best = candidate;
    best_length = stem.size();
  }
  if (best.empty()) {
    return absl::NotFoundError(fmt::format(
        "{}: expected an ASF file in the same folder whose name is a prefix of \"{}\", found none; "
        "set it with --skeleton",
        amc.string(), name));
  }
  return best;
}

absl::StatusOr<fs::path> SkeletonFor(const fs::path& file, const fs::path& given) {
  const std::string extension = MotionExtension(file);
  if (extension != ".amc" && extension != ".csv") return fs::path();
  if (!given.empty()) return given;
  return extension == ".amc" ? FindSkeletonBeside(file) : OnlyUrdfBeside(file);
}

absl::StatusOr<std::string> ReadFileBytes(const fs::path& path) {
  return ReadWholeFile(path, static_cast<size_t>(ClientOptions().max_send_bytes));
}

absl::StatusOr<std::string> ReadTextFile(const fs::path& path) {
  auto text = ReadFileBytes(path);
  if (!text.ok() || text::IsUtf8(*text)) return text;
  return absl::InvalidArgumentError(fmt::format("{}: is not UTF-8 text", path.string()));
}

absl::StatusOr<v1::Observation> ObservationFromFile(const fs::path& file,
                                                    const SourceOptions& options) {
  auto bytes = ReadFileBytes(file);
  if (!bytes.ok()) return bytes.status();
  const auto skeleton = SkeletonFor(file, options.skeleton);
  if (!skeleton.ok()) return skeleton.status();
  v1::Observation observation;
  v1::FileObservation& sent = *observation.mutable_file();
  sent.set_file_name(file.filename().string());
  sent.set_data(*std::move(bytes));
  *sent.mutable_conventions() = Conventions(options);
  if (!skeleton->empty()) {
    auto skeleton_bytes = ReadFileBytes(*skeleton);
    if (!skeleton_bytes.ok()) return skeleton_bytes.status();
    sent.set_skeleton_file_name(skeleton->filename().string());
    sent.set_skeleton_data(*std::move(skeleton_bytes));
  }
  return observation;
}

}  // namespace motiondb::client
