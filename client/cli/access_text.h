// Tokens and audit entries as text for the terminal.
#pragma once

#include <motiondb/messages.h>

#include <cstdint>
#include <string>
#include <vector>

#include "client/cli/terminal/table.h"

namespace motiondb::client {

// `now_seconds`: Unix time, for the state of the tokens.
Table TokensTable(const std::vector<v1::Token>& tokens, std::int64_t now_seconds);

// Whether a token gives access: it is neither revoked nor expired.
bool IsValid(const v1::Token& token, std::int64_t now_seconds);

// Returns name, role, database and expiry of a token in one line.
std::string TokenText(const v1::Token& token);

Table AuditTable(const v1::ListAuditEntriesResponse& response);

}  // namespace motiondb::client
