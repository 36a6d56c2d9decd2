// What a motion was recognized as, for a person. Pure function.
#pragma once

#include <motiondb/messages.h>

#include <string>

namespace motiondb::client {

// A line for each window: its time, the most probable labels, familiarity and the best clip; then
// how many windows each label leads.
std::string RecognitionText(const v1::RecognizeResponse& response);

}  // namespace motiondb::client
