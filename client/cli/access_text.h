// Tokens and the record of changes as tables for a person. Pure functions.
#pragma once

#include <motiondb/messages.h>

#include <cstdint>
#include <string>
#include <vector>

namespace motiondb::client {

// `now_seconds` since the Unix epoch tells which tokens have expired.
std::string TokensText(const std::vector<v1::Token>& tokens, std::int64_t now_seconds);

// One token in one line: whom it is good for, and how long.
std::string TokenText(const v1::Token& token);

std::string AuditText(const v1::ListAuditEntriesResponse& response);

}  // namespace motiondb::client
