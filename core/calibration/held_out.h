// Selects stored clips to test a model with, each held out of the model, and reads their motion.
#pragma once

#include <vector>

#include "core/motion/states.h"

namespace motiondb::core {

class Model;

// Returns for each clip whether a test of the clip `held_out` leaves it out. If the subject is
// known and other subjects have clips with the same label, all clips of the subject are left out,
// because the subject would reveal the label. If not, only the clip itself is left out.
std::vector<bool> LeftOutWith(const Model& model, int held_out);

// Returns at most `max_count` clips, ordered by label and subject, with the proportions of labels
// and subjects of the model. Evenly spread elements of the result also have these proportions. They
// do not depend on the order of the clips in the model.
std::vector<int> SampleClips(const Model& model, int max_count);

// Returns the unscaled states of a stored clip: of all frames, or of frames [first, end).
StateSequence StoredMotion(const Model& model, int clip);
StateSequence StoredMotion(const Model& model, int clip, int first, int end);

}  // namespace motiondb::core
