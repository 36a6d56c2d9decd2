// Pictures of queries.
#pragma once

#include "client/cli/command.h"

namespace motiondb::client {

// Adds estimate, recognize and plan.
void AddQueryPictureCommands(CommandLine line);

}  // namespace motiondb::client
