// The virtual markers of a database, asked of its server. Pure but for that.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "motiondb/client.h"

namespace motiondb::client {

// Names in the order of a state's markers. NOT_FOUND if there is no such database; errors of the
// connection.
absl::StatusOr<std::vector<std::string>> MarkerNames(const Client& client,
                                                     const std::string& database);

}  // namespace motiondb::client
