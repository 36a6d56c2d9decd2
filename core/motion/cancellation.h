// How a caller stops work that is no longer wanted.
#pragma once

#include <functional>

namespace motiondb::core {

// True once the answer is no longer wanted (deadline passed, client gone). Asked often, from the
// calling thread; an empty function never cancels.
using Cancelled = std::function<bool()>;

}  // namespace motiondb::core
