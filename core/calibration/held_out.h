// What a model without one of its clips would be asked, and whom it would ask. Pure functions; safe
// to call from any thread.
#pragma once

#include <vector>

#include "core/motion/states.h"

namespace motiondb::core {

class Model;

// Which clips are left out with a stored clip: all that its subject did, where the subject is known
// and others did the same, so that labels are not known by who moves; else the clip alone.
std::vector<bool> LeftOutWith(const Model& model, int held_out);

// At most `most` clips to be held out, spread evenly over the labels and, in a label, over the
// subjects: each has its share of the clips, whatever the order they were added in. In order of
// label and subject, so that some of them, spread evenly, are such a sample too.
std::vector<int> SampleClips(const Model& model, int most);

// A stored clip as it was given (not scaled).
StateSequence StoredMotion(const Model& model, int clip);

}  // namespace motiondb::core
