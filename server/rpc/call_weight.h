// What a call asks of the server. Safe to use from any thread.
#pragma once

#include <string_view>

namespace motiondb::server {

enum class CallWeight {
  kLight,   // milliseconds
  kHeavy,   // much processor time, memory or disk: goes through a lane of its own
  kStream,  // as long as the client likes, a little at a time
};

// Of "QueryService.Plan". What is not named is light.
CallWeight WeightOf(std::string_view method);

}  // namespace motiondb::server
