// Vectors that every x86-64 and ARM processor has.
#include "core/recognition/alignment_loops_in_vectors.h"

namespace motiondb::core {

const AlignmentLoops kPortableAlignmentLoops = AlignmentLoopsInVectors<4>::All();

}  // namespace motiondb::core
