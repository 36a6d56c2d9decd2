// Writes a model as a folder of NumPy files for other tools:
//   states.npy                    float32, frames x dimensions, scaled as in the tree
//   clip_of_frame.npy             int32, frames: index into model.json's model.clips
//   layers/LL/node_of_frame.npy   int32, frames
//   layers/LL/parent.npy          int32, nodes: node in the layer above; -1 in layer 1
//   layers/LL/mean.npy            float32, nodes x dimensions
//   layers/LL/variance.npy        float32, nodes x dimensions
//   layers/LL/transitions.npy     int32, transitions x 3: from, to, count
//   model.json                    the Model message, marker names, and a description of each file
// LL is the layer with at least two digits; layer 01 is the root alone.
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

// Creates `directory` if necessary. FAILED_PRECONDITION: it is not empty, without `force`. With
// `force`, removes only the files of an earlier dump.
absl::Status PrepareDumpDirectory(const std::filesystem::path& directory, bool force);

// Writes the current model of `database` (`databases/{database}`) into `directory` and returns its
// Model message. model.json is written last: if it exists, all other files are complete. Calls
// `on_progress` with the completed fraction and the current part.
absl::StatusOr<v1::Model> DumpModel(
    const Client& client, const std::string& database, const std::filesystem::path& directory,
    const std::function<void(double, const std::string&)>& on_progress);

enum class NpyType { kFloat32, kInt32 };

// Writes an array as a NumPy file: format version 1.0, C order, little-endian. It streams, so that
// the array need not fit into memory. The file gets its name in Finish.
class NpyWriter {
 public:
  // `shape` has one or two extents. Finish returns the first error.
  NpyWriter(std::filesystem::path path, NpyType type, const std::vector<int64_t>& shape);
  NpyWriter(const NpyWriter&) = delete;
  NpyWriter& operator=(const NpyWriter&) = delete;

  // Appends little-endian elements.
  void AppendBytes(std::string_view bytes);
  void Append(int32_t value);

  // Completes the file. DATA_LOSS: the number of elements does not match the shape. UNKNOWN: the
  // file cannot be written.
  absl::Status Finish();

 private:
  void Write(std::string_view bytes);

  const std::filesystem::path path_;
  int64_t missing_bytes_;
  absl::StatusOr<OutputFile> file_;  // or the first error
};

// Returns the header of a file: magic, version, length, and a description that is padded so that
// the elements begin at a multiple of 64 bytes.
std::string NpyHeader(NpyType type, const std::vector<int64_t>& shape);

}  // namespace motiondb::client
