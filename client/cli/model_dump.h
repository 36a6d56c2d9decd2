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

#include <filesystem>
#include <functional>
#include <string>

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

}  // namespace motiondb::client
