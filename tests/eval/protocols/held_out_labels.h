// Unknown motion in HDM05: each label and actor left out together.
#pragma once

#include "tests/eval/protocols/protocol.h"

namespace motiondb::tests {

// Whole clips for all methods, and windows for those of the database.
absl::StatusOr<Tables> HeldOutLabelTables(RecognitionStudy& study);

}  // namespace motiondb::tests
