// Arrays as NumPy files, format version 1.0, C order, little-endian; written as a stream, so that
// an array never has to be in memory. A file appears under its name when it is complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/output_file.h"

namespace motiondb::client {

enum class NpyType { kFloat32, kInt32 };

// Not thread-safe. Without Finish there is no file.
class NpyWriter {
 public:
  // `shape` has one or two extents. The first error is kept, and is Finish's.
  NpyWriter(std::filesystem::path path, NpyType type, std::vector<int64_t> shape);
  NpyWriter(const NpyWriter&) = delete;
  NpyWriter& operator=(const NpyWriter&) = delete;

  // Appends elements that are little-endian already.
  void AppendBytes(std::string_view bytes);
  void Append(int32_t value);

  // Completes the file. DATA_LOSS if there are not as many elements as the shape says; UNKNOWN if
  // the file could not be written.
  absl::Status Finish();

 private:
  void Write(std::string_view bytes);

  const std::filesystem::path path_;
  int64_t missing_bytes_;
  absl::StatusOr<OutputFile> file_;  // or the first error
};

// All that stands in a file before its elements: magic, version, length, and a description padded
// so that the elements begin at a multiple of 64 bytes.
std::string NpyHeader(NpyType type, const std::vector<int64_t>& shape);

}  // namespace motiondb::client
