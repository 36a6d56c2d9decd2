// Fits the probability that a motion is unknown (core/recognition/unknown.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/recognition/unknown.h"

namespace motiondb::core {

// A held-out observation: known if the model kept other clips of its label, unknown if it was
// aligned without all clips of its label and of its subject.
struct UnknownSample {
  bool is_unknown = false;
  int clip = 0;
  std::size_t label = 0;  // of the clip, an index into the labels
  BestLabel best;
  double own_log_distance = 0;  // known: LogDistance of its own label
};

// Fits the model by FitUnknownRegression; nullopt as there.
//
// The log distance of a label is the mean of its known clips, shrunk towards that of all labels as
// by 4 more clips; a sample is compared with it without its own clip. The lead is not used if
// unknown samples can have only one label.
std::optional<UnknownModel> FitUnknownModel(const std::vector<std::string>& labels,
                                            const std::vector<UnknownSample>& samples);

}  // namespace motiondb::core
