// What recognition by alignment is worth, for windows and for whole observations. Safe to call from
// any thread; uses only the threads lent to it.
#pragma once

#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

class Model;

// How many of the clips asked about are also tried as whole observations, in a model of `clips`
// clips (> 0) and `frames` frames: 128, or fewer in a model of very long clips, but at least 8. It
// bounds the time of the calibration, which is else quadratic in the length of the clips.
int ClipsTriedWhole(int clips, double frames);

// Recognizes at most 128 stored clips, spread evenly, each with the model of the other clips
// (LeftOutWith): some 512 windows of 0.4 s, and of ClipsTriedWhole clips the first 10 to 100 % as
// whole observations. A clip with a label of its own calibrates the familiarity only. A calibration
// without samples keeps its default. Returns CANCELLED if `progress` returns false.
absl::StatusOr<RecognitionCalibration> CalibrateRecognition(const Model& model,
                                                            const ParallelFor& parallel,
                                                            const BuildProgress& progress);

}  // namespace motiondb::core
