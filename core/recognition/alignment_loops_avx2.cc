// Compiled for x86-64 processors with AVX2, which those of the last ten years have.
#include "core/recognition/alignment_loops_in_vectors.h"

namespace motiondb::core {

const AlignmentLoops kAvx2AlignmentLoops = AlignmentLoopsInVectors<8>::All();

}  // namespace motiondb::core
