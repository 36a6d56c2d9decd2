// Requests of motiondb-import: one JSON object in one line names a file and how to read it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "import/sandbox.h"

namespace motiondb::importer {

// Bytes of a file, mapped into memory.
class InputBytes {
 public:
  // NOT_FOUND, or INVALID_ARGUMENT for a folder or a file above `max_bytes`.
  static absl::StatusOr<InputBytes> Open(const std::string& path, std::size_t max_bytes);

  InputBytes() = default;
  InputBytes(InputBytes&& other) noexcept;
  InputBytes& operator=(InputBytes&& other) noexcept;
  ~InputBytes();

  std::string_view bytes() const { return {data_, size_}; }

 private:
  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

struct FileRequest {
  std::string file;           // path
  std::string name;           // for messages and, without `format`, for the format; empty: the path
  std::string skeleton;       // path of the ASF of an AMC file or the URDF of a robot; empty: none
  std::string skeleton_name;  // for messages; empty: the path
  std::optional<core::FileFormat> format;
  core::ReadOptions given;
  std::optional<double> leg_length_m;          // inspect
  std::optional<core::FileFormat> written_as;  // convert

  const std::string& shown_name() const { return name.empty() ? file : name; }
};

// INVALID_ARGUMENT says what is wrong with the line.
absl::StatusOr<FileRequest> ParseFileRequest(std::string_view line);

// Limits of one request.
struct FileLimits {
  SandboxLimits process;
  std::size_t max_file_bytes = std::size_t{64} << 20;    // of each file
  std::size_t max_plain_bytes = std::size_t{256} << 20;  // of a file after decompression
  bool is_sandboxed = true;
};

// The files of a request, mapped into memory.
class RequestedFiles {
 public:
  // Errors name the file. `max_bytes`: of each file.
  static absl::StatusOr<RequestedFiles> Open(const FileRequest& request, std::size_t max_bytes);

  // Reads the motion in any format, gzip included. Called in the sandbox. `max_bytes`: after
  // decompression. Errors: see ReadMotionFile.
  absl::StatusOr<core::MotionFile> Read(const FileRequest& request, std::size_t max_bytes) const;

  core::FileFormat format() const { return format_; }
  std::optional<core::SourceFile> skeleton(const FileRequest& request) const;

 private:
  core::FileFormat format_ = core::FileFormat::kBvh;
  InputBytes file_;
  InputBytes skeleton_;
};

// Returns the error of a file whose reader ended without a result (`failure` of Child::Finish),
// with the file, its format and what a user can do. RESOURCE_EXHAUSTED as in `failure`; a crash is
// INVALID_ARGUMENT: the file is at fault, not the environment of the caller.
absl::Status ReaderFailure(const FileRequest& request, core::FileFormat format,
                           const absl::Status& failure);

}  // namespace motiondb::importer
