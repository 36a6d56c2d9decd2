// Implementation of core::ParallelFor for tests.
#pragma once

#include "core/motion/execution.h"

namespace motiondb::tests {

// `jobs` threads run the bodies in order of index (1: the calling thread). Cannot be nested.
core::ParallelFor RunOnThreads(int jobs);

// Returns the processor time of the calling thread, s: the cost of a query on a busy machine.
double ThreadCpuSeconds();

}  // namespace motiondb::tests
