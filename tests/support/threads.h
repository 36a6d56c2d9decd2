// Threads for core's ParallelFor.
#pragma once

#include "core/tree/parallel.h"

namespace motiondb::tests {

// Bodies are taken in order of index by `jobs` threads (1: the calling one). Not to be nested.
core::ParallelFor OnThreads(int jobs);

// Seconds of processor time that the calling thread has used: what a query costs on a busy machine.
double ThreadSeconds();

}  // namespace motiondb::tests
