// How far filled-in markers are from where they were: a part of the hard conditions.
#pragma once

#include "absl/status/statusor.h"
#include "tests/eval/conditions.h"
#include "tests/eval/recognition_study.h"
#include "tests/eval/table.h"

namespace motiondb::tests {

// For each condition in which markers are missing, the mean error of every missing marker of
// database 1's test clips by core::Estimate, what it said it would be, and by the peers.
absl::StatusOr<Table> FillingErrors(RecognitionStudy& study,
                                    const std::vector<Condition>& conditions);

}  // namespace motiondb::tests
