#include "client/cli/marker_names.h"

#include <motiondb/v1/database.pb.h>

#include "client/cli/resource_name.h"

namespace motiondb::client {

absl::StatusOr<std::vector<std::string>> MarkerNames(const Client& client,
                                                     const std::string& database) {
  v1::GetDatabaseRequest request;
  request.set_name(DatabaseName(database));
  const auto response = client.GetDatabase(request);
  if (!response.ok()) return response.status();
  const auto& names = response->database().marker_names();
  return std::vector<std::string>(names.begin(), names.end());
}

}  // namespace motiondb::client
