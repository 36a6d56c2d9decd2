#include "client/cli/access_text.h"

#include <fmt/format.h>
#include <motiondb/v1/access.pb.h>

#include "absl/status/status.h"
#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/table.h"

namespace motiondb::client {
namespace {

std::string DatabaseWord(const v1::Token& token) {
  return token.database().empty() ? "(all)" : ShortName(token.database());
}

std::string StateText(const v1::Token& token, std::int64_t now_seconds) {
  if (token.has_revoke_time()) return "revoked";
  if (!token.has_expire_time()) return "good";
  return token.expire_time().seconds() <= now_seconds ? "expired" : "good";
}

}  // namespace

std::string TokensText(const std::vector<v1::Token>& tokens, std::int64_t now_seconds) {
  if (tokens.empty()) return "no tokens yet: make one with `motiondb token create --role ROLE`\n";
  Table table({{"TOKEN"}, {"ROLE"}, {"DATABASE"}, {"STATE"}, {"EXPIRES"}, {"CREATED"}, {"FOR"}});
  for (const v1::Token& token : tokens) {
    table.AddRow({ShortName(token.name()), LastWord(v1::Role_Name(token.role())),
                  DatabaseWord(token), StateText(token, now_seconds),
                  token.has_expire_time() ? TimeText(token.expire_time()) : "never",
                  TimeText(token.create_time()), token.description()});
  }
  return table.ToString();
}

std::string TokenText(const v1::Token& token) {
  return fmt::format(
      "{}: {} of {}, {}", token.name(), LastWord(v1::Role_Name(token.role())),
      token.database().empty() ? "all databases" : token.database(),
      token.has_expire_time() ? "until " + TimeText(token.expire_time()) : "until it is revoked");
}

std::string AuditText(const v1::ListAuditEntriesResponse& response) {
  if (response.entries().empty()) return "nothing was changed yet\n";
  Table table({{"TIME"}, {"WHO"}, {"FROM"}, {"CALL"}, {"ON"}, {"ENDED"}, {"REQUEST"}});
  for (const v1::AuditEntry& entry : response.entries()) {
    table.AddRow({TimeText(entry.time()), entry.principal(), entry.peer(), entry.method(),
                  entry.resource(),
                  absl::StatusCodeToString(static_cast<absl::StatusCode>(entry.code())),
                  entry.request_id()});
  }
  return table.ToString();
}

}  // namespace motiondb::client
