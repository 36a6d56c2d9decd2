// A model as a folder of NumPy files, for reading with other tools:
//   states.npy                    float32, frames x dimensions, scaled as the tree sees them
//   clip_of_frame.npy             int32, frames: index into model.json's model.clips
//   layers/LL/node_of_frame.npy   int32, frames
//   layers/LL/parent.npy          int32, nodes: node in the layer above; -1 in layer 1
//   layers/LL/mean.npy            float32, nodes x dimensions
//   layers/LL/variance.npy        float32, nodes x dimensions
//   layers/LL/transitions.npy     int32, transitions x 3: from, to, count
//   model.json                    the Model message, marker names, and words on each file
// LL is the layer's number, 1 for the root alone, with two digits or more.
#pragma once

#include <motiondb/client.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/output_file.h"

namespace motiondb::client {

// Makes `directory` ready: creates it, refuses one that holds anything (FAILED_PRECONDITION), and
// with `force` removes an earlier dump from it, and nothing else.
absl::Status PrepareDumpDirectory(const std::filesystem::path& directory, bool force);

// Writes the current model of `database` (`databases/{database}`) into `directory` and returns its
// figures. model.json comes last: where it stands, all other files are complete. `on_progress` is
// told the fraction done and what is being read.
absl::StatusOr<v1::Model> DumpModel(
    const Client& client, const std::string& database, const std::filesystem::path& directory,
    const std::function<void(double, const std::string&)>& on_progress);

// Arrays as NumPy files, format version 1.0, C order, little-endian; written as a stream, so that
// an array never has to be in memory. A file appears under its name when it is complete.
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
