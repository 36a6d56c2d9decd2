// Sorting of many numbers that are spread about evenly, as projections of states are: faster than
// comparing. Safe to call from any thread; uses only the threads lent to it.
#pragma once

#include <span>

#include "core/tree/parallel.h"

namespace motiondb::core {

// Sorts finite values, ascending, the same on any number of threads. `scratch` is as long as they
// are. They are dealt into buckets by value, which are then sorted: O(n) where they are spread
// about evenly, O(n log n) at worst.
void SortValues(std::span<double> values, std::span<double> scratch, const ParallelFor& parallel);

}  // namespace motiondb::core
