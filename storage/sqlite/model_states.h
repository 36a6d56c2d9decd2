// The states and the root path of a model: those of its clips, read by several connections at once
// straight to where they stay. Not thread-safe, except where it says so.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/tree/parallel.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

class ModelStates {
 public:
  // Finds the clips of the build that a current model is or extends, and takes memory for their
  // frames, with room for those of the clips that were added. DATA_LOSS, before it is taken, if the
  // clips' states do not hold so many.
  static absl::StatusOr<std::unique_ptr<ModelStates>> Find(Connection& connection,
                                                           std::int64_t current_key,
                                                           std::int64_t built_key);

  // Reads clips that no other call has begun, until none is left. Each thread has a connection of
  // its own, in a transaction. One that sees another moment, in which the model is not current,
  // reads nothing: what a model needs stays as it is as long as it is current. What went wrong with
  // a clip is told by MoveInto. Thread-safe.
  absl::Status ReadSome(Connection& connection);

  // When all have been read: moves them into the build that they belong to and scales them. The
  // first clip with an error in order of frames, or DATA_LOSS if the model has other clips.
  absl::Status MoveInto(core::ModelParts& parts, const core::ParallelFor& parallel);

 private:
  struct Clip {
    std::int64_t key = 0;
    std::string id;
    std::int32_t first_frame = 0;
    std::int32_t frame_count = 0;
    std::int64_t bytes = 0;  // of its states' blob
    std::vector<core::FrameSpan> glitches;
    absl::Status status;
  };
  explicit ModelStates(std::int64_t current_key) : current_key_(current_key) {}
  absl::Status FindClips(Connection& connection, std::int64_t built_key);
  absl::Status Read(Connection& connection, Clip& clip);

  const std::int64_t current_key_;
  std::vector<Clip> clips_;
  std::atomic<std::size_t> next_ = 0;  // clip that nobody has begun
  std::int64_t room_ = 0;              // for frames of clips that were added, or will be
  core::FrameMatrix states_;
  core::RootPath root_path_;
};

}  // namespace motiondb::storage
