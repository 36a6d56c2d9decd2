// Operations as text for the terminal.
#pragma once

#include <motiondb/messages.h>

#include <vector>

#include "client/cli/terminal/table.h"

namespace motiondb::client {

Table OperationsTable(const std::vector<v1::Operation>& operations);

}  // namespace motiondb::client
