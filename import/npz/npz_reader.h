// Reads human motion from NumPy archives (.npz).
#pragma once

#include <cstddef>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "import/npz/npz_values.h"

namespace motiondb::importer {

// Recognizes, by the arrays of the archive (F: frames; rotations are axis-angle vectors in radians,
// translations metres):
//   motiondb     motiondb_version ...: the layout of core/export/writers.h
//   AMASS        poses (F, 156 SMPL-H or 165 SMPL-X), or root_orient (F, 3), pose_body (F, 63),
//                pose_hand (F, 90), pose_jaw (F, 3), pose_eye (F, 6); trans (F, 3);
//                mocap_framerate or mocap_frame_rate; gender; surface_model_type. z up.
//   SMPL family  poses (F, 66, 72, 156 or 165), or the arrays of AMASS; trans; fps. Up axis:
//                deduced from the motion, or y.
//   AIST++       smpl_poses (F, 72), smpl_trans (F, 3) divided by smpl_scaling. Up axis: deduced,
//                or y.
// Rotations may also have the shape (F, joints, 3). Ignores all other arrays.
//
// The SMPL family has a mean body (import/npz/smpl_body.h), which a note reports; `betas`, the
// shape of the subject, needs the licensed model and is ignored with a note. The pelvis is at trans
// + SmplPelvis. Joints without rotations in the file do not move.
//
// Frame rate: `options`, or the file. Without both, SMPL is assumed to have 30 Hz and AIST++ 60 Hz,
// with a note; SMPL-H and SMPL-X are rejected, because AMASS always states it. A unit in `options`
// applies to translations.
//
// `max_bytes`: limit of the decompressed arrays that are read, and of the resulting motion.
// INVALID_ARGUMENT names file and array, and for numbers frame and column, from 0. Errors about
// missing arrays list those that are there.
absl::StatusOr<core::MotionFile> ReadNpz(core::SourceFile file, const core::ReadOptions& options,
                                         std::size_t max_bytes);

// The parts of ReadNpz.

// Whether the archive has arrays of rotations of a body model.
bool IsSmpl(const NpzArchive& archive);

// See ReadNpz. REQUIRES: IsSmpl.
absl::StatusOr<core::MotionFile> ReadSmpl(const NpzSource& source,
                                          const core::ReadOptions& options);

// Reads motiondb's own layout. Joints get three rotations each, and three translations where their
// local positions change. `rest_rotations` may be absent: no rotation. Ignores the world positions
// of joints, which follow from the local ones. Errors: see ReadNpz.
absl::StatusOr<core::MotionFile> ReadMotiondbNpz(const NpzSource& source,
                                                 const core::ReadOptions& options);

}  // namespace motiondb::importer
