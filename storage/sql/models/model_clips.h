// The table model_clip: which stored clips a model was built from. The states of a model are those
// of its clips.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/motion/execution.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Whether FindModelClips also accepts deleted clips.
enum class DeletedClips { kNot, kToo };
// Returns the keys of the model's clips with indices `first` to `end` - 1. NOT_FOUND also if a
// stored clip has the same id but other states.
absl::StatusOr<std::vector<std::int64_t>> FindModelClips(Connection& connection,
                                                         std::int64_t database_key,
                                                         const core::Model& model,
                                                         std::ptrdiff_t first, std::ptrdiff_t end,
                                                         DeletedClips deleted);

// Inserts the clips with these keys; the first one has the index `first` in the model.
absl::Status InsertModelClips(Connection& connection, std::int64_t model_key, std::int64_t first,
                              const std::vector<std::int64_t>& clip_keys);

// Reads the states and the root path of a model from its clips, on several connections in parallel,
// directly into the memory of the model.
class ModelStates {
 public:
  // Finds the clips of a build and allocates memory for their frames and for those of added clips.
  // `current_key`: the current model; `built_key`: the build that it is or extends. DATA_LOSS,
  // before memory is allocated, if the stored states have fewer bytes than these frames need.
  static absl::StatusOr<std::unique_ptr<ModelStates>> Find(Connection& connection,
                                                           std::int64_t current_key,
                                                           std::int64_t built_key);

  // Reads clips that no other call has begun, until none is left. Thread-safe: each thread has its
  // own connection, in a transaction. Reads nothing if the model is not current in that
  // transaction: only the data of a current model is guaranteed to exist. MoveInto returns errors
  // of clips.
  absl::Status ReadPending(Connection& connection);

  // Moves the states into the parts of the build and scales them. Call it after all reads. Returns
  // the error of the first clip that has one; DATA_LOSS if the model has other clips.
  absl::Status MoveInto(core::ModelParts& parts, const core::ParallelFor& parallel);

 private:
  struct Clip {
    std::int64_t key = 0;
    std::string id;
    std::int32_t first_frame = 0;
    std::int32_t frame_count = 0;
    std::int64_t bytes = 0;  // size of its states blob
    std::vector<core::FrameSpan> glitches;
    absl::Status status;
  };
  explicit ModelStates(std::int64_t current_key) : current_key_(current_key) {}
  absl::Status FindClips(Connection& connection, std::int64_t built_key);
  absl::Status Read(Connection& connection, Clip& clip);

  const std::int64_t current_key_;
  std::vector<Clip> clips_;
  std::atomic<std::size_t> next_ = 0;  // next clip to read
  std::int64_t room_ = 0;              // spare frames for clips that were or will be added
  core::FrameMatrix states_;
  core::RootPath root_path_;
};

}  // namespace motiondb::storage
