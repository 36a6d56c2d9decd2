// Errors of estimated missing markers: a part of the hard conditions.
#pragma once

#include "absl/status/statusor.h"
#include "tests/eval/conditions.h"
#include "tests/eval/recognition_study.h"
#include "tests/eval/table.h"

namespace motiondb::tests {

// Returns for each condition with missing markers the mean error over all missing markers of
// database 1's test clips: by core::Estimate (with its expected error) and by the peers.
absl::StatusOr<Table> FillingErrors(RecognitionStudy& study,
                                    const std::vector<Condition>& conditions);

}  // namespace motiondb::tests
