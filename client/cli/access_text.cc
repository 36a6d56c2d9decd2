#include "client/cli/access_text.h"

#include <fmt/format.h>
#include <motiondb/v1/access.pb.h>

#include "absl/status/status.h"
#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

std::string DatabaseWord(const v1::Token& token) {
  return token.database().empty() ? "(all)" : ShortName(token.database());
}

std::string StateText(const v1::Token& token, std::int64_t now_seconds) {
  if (token.has_revoke_time()) return "revoked";
  if (!token.has_expire_time()) return "valid";
  return token.expire_time().seconds() <= now_seconds ? "expired" : "valid";
}

}  // namespace

bool IsValid(const v1::Token& token, std::int64_t now_seconds) {
  return StateText(token, now_seconds) == "valid";
}

Table TokensTable(const std::vector<v1::Token>& tokens, std::int64_t now_seconds) {
  Table table({{"TOKEN"}, {"ROLE"}, {"DATABASE"}, {"STATE"}, {"EXPIRES"}, {"CREATED"}, {"FOR"}});
  for (const v1::Token& token : tokens) {
    const std::string state = StateText(token, now_seconds);
    table.AddRow({ShortName(token.name()), EnumValueText(v1::Role_Name(token.role())),
                  DatabaseWord(token),
                  Cell(state, state == "valid" ? Style::kGood : Style::kWarning),
                  token.has_expire_time() ? TimeText(token.expire_time()) : "never",
                  TimeText(token.create_time()), token.description()});
  }
  return table;
}

std::string TokenText(const v1::Token& token) {
  return fmt::format(
      "{}: {} of {}, {}", token.name(), EnumValueText(v1::Role_Name(token.role())),
      token.database().empty() ? "all databases" : token.database(),
      token.has_expire_time() ? "until " + TimeText(token.expire_time()) : "until it is revoked");
}

Table AuditTable(const v1::ListAuditEntriesResponse& response) {
  Table table({{"TIME"}, {"WHO"}, {"FROM"}, {"CALL"}, {"ON"}, {"ENDED"}, {"REQUEST"}});
  for (const v1::AuditEntry& entry : response.entries()) {
    table.AddRow({TimeText(entry.time()), entry.principal(), entry.peer(), entry.method(),
                  entry.resource(),
                  absl::StatusCodeToString(static_cast<absl::StatusCode>(entry.code())),
                  entry.request_id()});
  }
  return table;
}

}  // namespace motiondb::client
