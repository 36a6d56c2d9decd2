// Compiled for x86-64 processors with AVX2, which those of the last ten years have.
#include "core/tree/row_loops_in_vectors.h"

namespace motiondb::core {

const RowLoops kAvx2RowLoops = RowLoopsInVectors<8>::All();

}  // namespace motiondb::core
