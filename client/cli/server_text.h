// The state of a server, its tokens and its audit log as text for the terminal.
#pragma once

#include <motiondb/messages.h>

#include <cstdint>
#include <string>
#include <vector>

#include "client/cli/terminal/table.h"

namespace motiondb::client {

// Returns the state of a server, which fits on one screen. `now_us`: microseconds since the Unix
// epoch.
std::string StatusText(const v1::GetServerStatusResponse& status, std::int64_t now_us);

// Returns a duration in its two largest units: "12 s", "3 min 4 s", "5 h 0 min", "2 d 7 h".
std::string DurationText(std::int64_t seconds);

// Returns a size in its largest unit: "512 B", "1.5 MiB".
std::string BytesText(std::int64_t bytes);

// `now_seconds`: Unix time, for the state of the tokens.
Table TokensTable(const std::vector<v1::Token>& tokens, std::int64_t now_seconds);

// Whether a token gives access: it is neither revoked nor expired.
bool IsValid(const v1::Token& token, std::int64_t now_seconds);

// Returns name, role, database and expiry of a token in one line.
std::string TokenText(const v1::Token& token);

Table AuditTable(const v1::ListAuditEntriesResponse& response);

}  // namespace motiondb::client
