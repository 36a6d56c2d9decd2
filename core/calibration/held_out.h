// Selects stored units (core/model/label_units.h) to test a model with, each held out of the model,
// and reads their motion.
#pragma once

#include <memory>
#include <vector>

#include "core/motion/states.h"

namespace motiondb::core {

class ClipMask;
class Model;
struct LabelUnit;

// Returns for each clip whether a test of a unit leaves it out. If the subject is known and other
// subjects have units with the same label, all clips of the subject are left out, because the
// subject would reveal the label. If not, only the unit's clip is left out.
std::vector<bool> LeftOutWith(const Model& model, const LabelUnit& held_out);

// Returns the mask of the other clips; null if all are left out.
std::shared_ptr<const ClipMask> MaskWithout(const Model& model, std::vector<bool> left_out);

// Returns at most `max_count` units of kActionTrack, ordered by label and subject, with the
// proportions of labels and subjects of the model. Evenly spread elements of the result also have
// these proportions. They do not depend on the order of the clips in the model.
std::vector<LabelUnit> SampleUnits(const Model& model, int max_count);

// Returns the unscaled states of a stored clip or unit, or of frames [first, end) of a clip.
StateSequence StoredMotion(const Model& model, int clip);
StateSequence StoredMotion(const Model& model, const LabelUnit& unit);
StateSequence StoredMotion(const Model& model, int clip, int first, int end);

}  // namespace motiondb::core
