// Vectors that every x86-64 and ARM processor has.
#include "core/tree/row_loops_in_vectors.h"

namespace motiondb::core {

const RowLoops kPortableRowLoops = RowLoopsInVectors<4>::All();

}  // namespace motiondb::core
