#include "core/recognition/alignment_loops.h"

#include "core/tree/wide_vectors.h"

namespace motiondb::core {

const AlignmentLoops& LoopsOfAlignment() {
#if defined(__x86_64__)
  if (WideVectors()) return kAvx2AlignmentLoops;
#endif
  return kPortableAlignmentLoops;
}

}  // namespace motiondb::core
