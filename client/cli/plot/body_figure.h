// The figure of a person in a motion file, from the front and from the left.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "client/cli/plot/canvas.h"

namespace motiondb::client {

// Returns a picture of the joints or markers of a result of motiondb-import in its middle
// frame; points with a role have its name as a tooltip and a colour of their side.
Canvas BodyPicture(const nlohmann::json& inspection);

}  // namespace motiondb::client
