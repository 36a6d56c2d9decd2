#include "import/file_request.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "core/format/gunzip.h"
#include "core/motion/error.h"
#include "import/npz/npz_reader.h"
#include "import/scene/scene_reader.h"

namespace motiondb::importer {

absl::StatusOr<InputBytes> InputBytes::Open(const std::string& path, std::size_t max_bytes) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) {
    return errno == ENOENT ? absl::NotFoundError("no such file")
                           : absl::InvalidArgumentError(std::strerror(errno));
  }
  const absl::Cleanup close_file = [file] { close(file); };
  struct stat status {};
  if (fstat(file, &status) != 0) return absl::InvalidArgumentError(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return absl::InvalidArgumentError("expected a regular file");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > max_bytes) {
    return absl::InvalidArgumentError(fmt::format("expected at most {} MiB, got {:.1f} MiB",
                                                  max_bytes >> 20,
                                                  static_cast<double>(size) / (1 << 20)));
  }
  InputBytes input;
  if (size == 0) return input;
  void* const data = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
  if (data == MAP_FAILED) return absl::InvalidArgumentError(std::strerror(errno));
  input.data_ = static_cast<const char*>(data);
  input.size_ = size;
  return input;
}

InputBytes::InputBytes(InputBytes&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

InputBytes& InputBytes::operator=(InputBytes&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

InputBytes::~InputBytes() {
  if (data_ != nullptr) munmap(const_cast<char*>(data_), size_);
}

namespace {

using RequestJson = nlohmann::json;

std::optional<double> OptionalNumber(const RequestJson& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) return std::nullopt;
  return found->get<double>();
}

// A field with the name of a format, such as "fbx".
absl::StatusOr<std::optional<core::FileFormat>> OptionalFormat(const RequestJson& object,
                                                               const char* field) {
  const std::string name = object.value(field, "");
  if (name.empty()) return std::nullopt;
  for (const core::FormatInfo& info : core::KnownFormats()) {
    if (info.name == name) return info.format;
  }
  return core::InvalidArgument("{}: unknown format '{}'", field, name);
}

absl::StatusOr<std::optional<core::UpAxis>> OptionalUpAxis(const RequestJson& object) {
  const std::string name = object.value("up_axis", "");
  if (name.empty()) return std::nullopt;
  for (const auto axis : {core::UpAxis::kX, core::UpAxis::kY, core::UpAxis::kZ}) {
    if (core::NameOf(axis) == name) return axis;
  }
  return core::InvalidArgument("up_axis: expected x, y or z, got '{}'", name);
}

absl::StatusOr<InputBytes> OpenNamed(const std::string& path, std::string_view name,
                                     std::size_t max_bytes) {
  auto opened = InputBytes::Open(path, max_bytes);
  if (opened.ok()) return opened;
  return core::InvalidArgument("{}: {}", name, std::string(opened.status().message()));
}

}  // namespace

absl::StatusOr<FileRequest> ParseFileRequest(std::string_view line) {
  try {
    const RequestJson object = RequestJson::parse(line);
    FileRequest request;
    request.file = object.at("file").get<std::string>();
    request.name = object.value("name", "");
    request.skeleton = object.value("skeleton", "");
    request.skeleton_name = object.value("skeleton_name", "");
    request.given.metres_per_unit = OptionalNumber(object, "metres_per_unit");
    request.given.frame_rate_hz = OptionalNumber(object, "frame_rate_hz");
    request.given.take = object.value("take", "");
    request.leg_length_m = OptionalNumber(object, "leg_length_m");
    MOTIONDB_ASSIGN_OR_RETURN(request.given.up_axis, OptionalUpAxis(object));
    MOTIONDB_ASSIGN_OR_RETURN(request.format, OptionalFormat(object, "format"));
    MOTIONDB_ASSIGN_OR_RETURN(request.written_as, OptionalFormat(object, "written_as"));
    return request;
  } catch (const nlohmann::json::exception& error) {
    return absl::InvalidArgumentError(error.what());
  }
}

absl::StatusOr<RequestedFiles> RequestedFiles::Open(const FileRequest& request,
                                                    std::size_t max_bytes) {
  RequestedFiles files;
  MOTIONDB_ASSIGN_OR_RETURN(files.file_, OpenNamed(request.file, request.shown_name(), max_bytes));
  if (request.format) {
    files.format_ = *request.format;
  } else {
    MOTIONDB_ASSIGN_OR_RETURN(files.format_, core::FormatOfPath(request.shown_name()));
  }
  if (request.skeleton.empty()) return files;
  const std::string& name =
      request.skeleton_name.empty() ? request.skeleton : request.skeleton_name;
  MOTIONDB_ASSIGN_OR_RETURN(files.skeleton_, OpenNamed(request.skeleton, name, max_bytes));
  return files;
}

absl::Status ReaderFailure(const FileRequest& request, core::FileFormat format,
                           const absl::Status& failure) {
  const bool is_limit = absl::IsResourceExhausted(failure);
  return absl::Status(
      is_limit ? absl::StatusCode::kResourceExhausted : absl::StatusCode::kInvalidArgument,
      fmt::format("{}: {}. This {} file is rejected, and nothing is stored. {}",
                  request.shown_name(), std::string(failure.message()), core::InfoOf(format).name,
                  is_limit ? "Shorten its motion, or remove its meshes and textures"
                           : "Export it again, or in another format (such as glb or bvh)"));
}

std::optional<core::SourceFile> RequestedFiles::skeleton(const FileRequest& request) const {
  if (request.skeleton.empty()) return std::nullopt;
  const std::string& name =
      request.skeleton_name.empty() ? request.skeleton : request.skeleton_name;
  return core::SourceFile{name, skeleton_.bytes()};
}

absl::StatusOr<core::MotionFile> RequestedFiles::Read(const FileRequest& request,
                                                      std::size_t max_bytes) const {
  MOTIONDB_RETURN_IF_ERROR(core::CheckReadOptions(format_, request.shown_name(), request.given));
  std::string plain_file;
  MOTIONDB_ASSIGN_OR_RETURN(
      const core::SourceFile file,
      core::PlainFile({request.shown_name(), file_.bytes()}, max_bytes, plain_file));
  const auto of_skeleton = skeleton(request);
  switch (format_) {
    case core::FileFormat::kFbx:
    case core::FileFormat::kGltf:
    case core::FileFormat::kCollada:
      return ReadScene(format_, file, request.given);
    case core::FileFormat::kNpz:
      return ReadNpz(file, request.given, max_bytes);
    default:
      return core::ReadMotionFile(format_, file, of_skeleton, request.given);
  }
}

}  // namespace motiondb::importer
