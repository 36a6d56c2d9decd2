// The name of a store: the path of a file, or the URL of a PostgreSQL database.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::storage {

// Reason of UNAVAILABLE if the server of a store cannot be reached. The call may be repeated.
inline constexpr char kStoreUnreachable[] = "STORE_UNREACHABLE";

// Returns whether a store's name is the URL of a PostgreSQL database: postgresql://... or
// postgres://...
bool IsPostgresUrl(std::string_view store);

// Returns the name of a store with "***" in place of each password, for messages.
std::string WithoutPassword(std::string_view store);

}  // namespace motiondb::storage
