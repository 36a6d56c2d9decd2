// Which vectors inner loops run in: one binary uses the widest that the processor at hand has, of
// those it was compiled for. Results are the same bits in all. Safe to call from any thread.
#pragma once

namespace motiondb::core {

// Whether loops run in vectors of 32 bytes (AVX2), not in those of 16 that every processor has.
bool WideVectors();

// For tests and benchmarks: from now on in vectors that every processor has, or in the widest
// again. False if these are the same here.
bool UseWideVectors(bool wide);

}  // namespace motiondb::core
