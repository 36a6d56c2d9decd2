// Selection of held-out clips, and their motion, to test a model on its own clips.
#pragma once

#include <vector>

#include "core/motion/states.h"

namespace motiondb::core {

class Model;

// Returns which clips to leave out together with a held-out clip: all clips of its subject, if the
// subject is known and other subjects have the same label, so that labels are not recognized by the
// subject; otherwise the clip alone.
std::vector<bool> LeftOutWith(const Model& model, int held_out);

// Returns at most `max_count` clips, in proportion to the number of clips of each label and
// subject, independent of their order in the model. Ordered by label and subject, so that an evenly
// spread part of the result is such a sample too.
std::vector<int> SampleClips(const Model& model, int max_count);

// Returns the states of a stored clip, not scaled; of all its frames or of [first, end).
StateSequence StoredMotion(const Model& model, int clip);
StateSequence StoredMotion(const Model& model, int clip, int first, int end);

}  // namespace motiondb::core
