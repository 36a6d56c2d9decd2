#include "server/engine/source_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "import/launch.h"
#include "server/engine/work/engine_options.h"
#include "storage/blob/motion_codec.h"
#include "storage/cancellable_lock.h"

namespace motiondb::server {
namespace {

using ImportJson = nlohmann::json;

// motiondb-import ends by itself before.
constexpr std::chrono::seconds kImportTimeout{2 * kImportCpuSeconds + 5};

// The running imports of this process.
storage::CancellableSemaphore& ImportSlots() {
  static storage::CancellableSemaphore slots(MaxImports());
  return slots;
}

// A file in memory that another process can open.
class SharedBytes {
 public:
  SharedBytes() = default;
  SharedBytes(SharedBytes&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  SharedBytes& operator=(SharedBytes&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~SharedBytes() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  // UNAVAILABLE if there is no memory or descriptor.
  static absl::StatusOr<SharedBytes> Make(std::string_view bytes) {
    constexpr int kLowest = 64;  // above the numbers that the other process gives them
    SharedBytes shared;
    const int created = memfd_create("motiondb-import", MFD_CLOEXEC);
    if (created >= 0) {
      shared.descriptor_ = fcntl(created, F_DUPFD_CLOEXEC, kLowest);
      close(created);
    }
    while (shared.descriptor_ >= 0 && !bytes.empty()) {
      const ssize_t written = write(shared.descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) break;
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    if (shared.descriptor_ >= 0 && bytes.empty()) return shared;
    return absl::UnavailableError(fmt::format("no memory to import: {}", std::strerror(errno)));
  }

  int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
};

std::string RequestLine(core::FileFormat format, core::SourceFile file,
                        const std::optional<core::SourceFile>& skeleton,
                        const core::ReadOptions& given) {
  ImportJson request = {{"file", importer::PathOfInheritedFile(0)},
                        {"name", file.name},
                        {"format", core::InfoOf(format).name}};
  if (skeleton) {
    request["skeleton"] = importer::PathOfInheritedFile(1);
    request["skeleton_name"] = skeleton->name;
  }
  if (given.metres_per_unit) request["metres_per_unit"] = *given.metres_per_unit;
  if (given.frame_rate_hz) request["frame_rate_hz"] = *given.frame_rate_hz;
  if (given.up_axis) request["up_axis"] = core::NameOf(*given.up_axis);
  if (!given.take.empty()) request["take"] = given.take;
  return request.dump(-1, ' ', false, ImportJson::error_handler_t::replace) + '\n';
}

absl::Status BadAnswer(std::string_view name) {
  return core::InvalidArgument("{}: cannot be read: motiondb-import gave no valid answer", name);
}

// The error that the program reports in the answer's header.
absl::Status ReportedError(std::string_view name, const ImportJson& header) {
  constexpr std::size_t kMaxMetadataBytes = 4096;
  const auto code = static_cast<absl::StatusCode>(header.value("code", 0));
  const std::string message = header.value("error", "");
  if (code == absl::StatusCode::kResourceExhausted) {
    return core::WithReason("IMPORT_LIMIT", absl::ResourceExhaustedError(message));
  }
  if (code != absl::StatusCode::kInvalidArgument) {
    return absl::InternalError(fmt::format("{}: motiondb-import failed: {}", name, message));
  }
  absl::Status error = absl::InvalidArgumentError(message);
  const std::string reason = header.value("reason", "");
  if (reason != "TAKE_REQUIRED" && reason != "TAKE_NOT_FOUND") return error;
  for (const char* const key : {"takes", "take_count"}) {
    const std::string value = header.value(key, "");
    if (value.size() <= kMaxMetadataBytes) {
      error = core::WithResource(key, value, std::move(error));
    }
  }
  return core::WithReason(reason, std::move(error));
}

// Collects the answer, which comes from a process that may be in the hands of the file.
class ImportAnswer {
 public:
  ImportAnswer(core::SourceFile file, const WorkOptions& terms) : file_(file), terms_(terms) {}

  // Appends a block. Reserves memory for the answer and the motion in it before it grows.
  absl::Status Add(std::string_view block) {
    if (!has_header_) {
      header_text_ += block;
      const std::size_t end = header_text_.find('\n');
      constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;
      if (end == header_text_.npos) {
        return header_text_.size() > kMaxHeaderBytes ? BadAnswer(file_.name) : absl::OkStatus();
      }
      has_header_ = true;
      const std::string rest = header_text_.substr(end + 1);
      header_text_.resize(end);
      MOTIONDB_RETURN_IF_ERROR(ReadHeader());
      bytes_left_ = content_bytes_;
      return Append(rest);
    }
    return Append(block);
  }

  absl::StatusOr<core::MotionFile> Parse() const {
    if (!has_header_ || bytes_left_ != 0) return BadAnswer(file_.name);
    storage::SpanSource source(std::as_bytes(std::span(content_)));
    auto read = storage::DecodeMotion(source);
    return read.ok() ? std::move(read) : BadAnswer(file_.name);
  }

 private:
  absl::Status ReadHeader() {
    try {
      const ImportJson header = ImportJson::parse(header_text_);
      if (header.contains("error")) return ReportedError(file_.name, header);
      content_bytes_ = header.at("bytes").get<std::size_t>();
    } catch (const ImportJson::exception&) {
      return BadAnswer(file_.name);
    }
    constexpr std::size_t kMaxContentBytes = std::size_t{1} << 30;
    if (content_bytes_ > kMaxContentBytes) return BadAnswer(file_.name);
    // The copy of the file, the answer, and the motion.
    MOTIONDB_RETURN_IF_ERROR(
        terms_.Reserve(std::ssize(file_.bytes) + 2 * static_cast<std::int64_t>(content_bytes_)));
    content_.reserve(content_bytes_);
    return absl::OkStatus();
  }

  absl::Status Append(std::string_view block) {
    if (block.size() > bytes_left_) return BadAnswer(file_.name);
    bytes_left_ -= block.size();
    content_ += block;
    return absl::OkStatus();
  }

  const core::SourceFile file_;
  const WorkOptions& terms_;
  std::string header_text_;
  bool has_header_ = false;
  std::size_t content_bytes_ = 0;
  std::size_t bytes_left_ = 0;
  std::string content_;
};

absl::StatusOr<core::MotionFile> Import(core::FileFormat format, core::SourceFile file,
                                        const std::optional<core::SourceFile>& skeleton,
                                        const core::ReadOptions& given, const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto slot, ImportSlots().Lock(terms.cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(const SharedBytes shared_file, SharedBytes::Make(file.bytes));
  SharedBytes shared_skeleton;
  std::vector<int> inherited = {shared_file.descriptor()};
  if (skeleton) {
    MOTIONDB_ASSIGN_OR_RETURN(shared_skeleton, SharedBytes::Make(skeleton->bytes));
    inherited.push_back(shared_skeleton.descriptor());
  }
  ImportAnswer answer(file, terms);
  const absl::Status ran = importer::RunImportProgram(
      {.arguments = {"read", "--max-memory-mib", std::to_string(kImportMemoryMib),
                     "--max-cpu-seconds", std::to_string(kImportCpuSeconds), "--max-file-mib",
                     "1024"},
       .lines = {RequestLine(format, file, skeleton, given)},
       .files = std::move(inherited),
       .timeout = kImportTimeout,
       .cancelled = terms.cancelled},
      [&](std::string_view block) { return answer.Add(block); });
  if (absl::IsDeadlineExceeded(ran)) {
    spdlog::error("import failed: {}", std::string(ran.message()));
    return core::WithReason("IMPORT_LIMIT", absl::ResourceExhaustedError(
                                                fmt::format("{}: reading takes longer than {} s",
                                                            file.name, kImportTimeout.count())));
  }
  if (absl::IsNotFound(ran)) {
    spdlog::error("import failed: {}", std::string(ran.message()));
    return core::WithReason(
        "IMPORT_NOT_INSTALLED",
        core::FailedPrecondition("{}: the server cannot read this format: motiondb-import is not "
                                 "installed beside it",
                                 file.name));
  }
  MOTIONDB_RETURN_IF_ERROR(ran);
  return answer.Parse();
}

}  // namespace

absl::StatusOr<core::MotionFile> ReadSource(core::FileFormat format, core::SourceFile file,
                                            std::optional<core::SourceFile> skeleton,
                                            const core::ReadOptions& given,
                                            const WorkOptions& terms) {
  if (core::NeedsImport(format, file.bytes)) {
    if (terms.allowed == AllowedWork::kLightWork) return HeavyWork();
    return Import(format, file, skeleton, given, terms);
  }
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(core::MaxBytesToRead(format, file, skeleton)));
  return core::ReadMotionFile(format, file, skeleton, given);
}

}  // namespace motiondb::server
