// What recognition by alignment is worth, for windows and for whole observations. Safe to call from
// any thread; uses only the threads lent to it.
#pragma once

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Asks about at most 128 stored clips, spread evenly, each without itself (ClipsLeft): some 512
// windows of 0.4 s, and the beginnings of each clip as whole observations, 10 to 100 % of it. A
// clip whose label no other has says what is familiar, but not how probable labels are. What cannot
// be found out stays at its default. CANCELLED.
absl::StatusOr<RecognitionCalibration> CalibrateRecognition(const Model& model,
                                                            const ParallelFor& parallel,
                                                            const BuildProgress& progress);

}  // namespace motiondb::core
