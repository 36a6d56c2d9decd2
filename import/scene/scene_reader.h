// Reads animated scenes: FBX, glTF 2.0 (also GLB and VRM) and Collada.
#pragma once

#include "absl/status/statusor.h"
#include "core/format/file_format.h"
#include "core/format/motion_file.h"

namespace motiondb::importer {

// Returns one take of the scene as joint motion. Joints: see FindSkeleton. Joint positions are
// those of the scene in every frame; rotations are without scales (see ScenePoses).
//
// `options.take`: the name of a take, or its number from 1; empty: the only one (see ChooseTake).
// Frames: see TimeTake. `options.frame_rate_hz` replaces the rate of these frames, as in other
// formats; it does not resample. Unit and up axis: see FindStatedConventions; deduced from the
// motion if neither given nor stated.
//
// INVALID_ARGUMENT names the file, and the node and key or frame. Opens no file, starts no thread.
// Throws std::bad_alloc if memory is short, nothing else. Hostile files can make assimp crash, hang
// or use all memory: call this in a process with limits (import/sandbox.h). REQUIRES: `format` is
// kFbx, kGltf or kCollada.
absl::StatusOr<core::MotionFile> ReadScene(core::FileFormat format, core::SourceFile file,
                                           const core::ReadOptions& options);

}  // namespace motiondb::importer
