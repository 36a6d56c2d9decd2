// motiondb audit: lists the audit log. motiondb token: creates, lists and revokes tokens.

#include <fmt/format.h>
#include <google/protobuf/util/time_util.h>
#include <motiondb/v1/access.pb.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>

#include "client/cli/command.h"
#include "client/cli/resource_name.h"
#include "client/cli/server_text.h"
#include "client/cli/terminal/print.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

struct AuditOptions {
  static constexpr bool kPrintsTable = true;
  int count = 100;
};

void Declare(CLI::App& command, AuditOptions& options) {
  command.add_option("--count", options.count, "Number of entries, newest first")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
}

absl::Status Run(const AuditOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ListAuditEntriesResponse all;
  v1::ListAuditEntriesRequest request;
  do {
    request.set_page_size(options.count - all.entries_size());
    const auto page = client->ListAuditEntries(request);
    if (!page.ok()) return page.status();
    all.mutable_entries()->MergeFrom(page->entries());
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty() && all.entries_size() < options.count);
  if (global.json) {
    for (const v1::AuditEntry& entry : all.entries()) PrintJson(entry);
  } else {
    PrintTable(AuditTable(all), global.csv, "no entries");
  }
  return absl::OkStatus();
}

}  // namespace

void AddAuditCommand(CommandLine line) {
  AddCommand<AuditOptions>(line, "audit",
                           "List changes and backups: who, what, when and from where",
                           "motiondb audit\nmotiondb audit --count 1000 --csv", Declare, Run);
}

// motiondb token create|list|revoke.

namespace {

struct TokenCreateOptions {
  v1::Role role = v1::ROLE_UNSPECIFIED;
  std::string database;
  double lifetime_seconds = 0;  // 0: unlimited
  std::string description;
};

struct TokenListOptions {
  static constexpr bool kPrintsTable = true;
};

struct TokenRevokeOptions {
  std::string token;
};

void DeclareCreate(CLI::App& command, TokenCreateOptions& options) {
  const std::map<std::string, v1::Role> roles = {
      {"reader", v1::ROLE_READER}, {"ingester", v1::ROLE_INGESTER}, {"admin", v1::ROLE_ADMIN}};
  command
      .add_option_function<std::string>(
          "--role", [&options, roles](const std::string& word) { options.role = roles.at(word); },
          "reader: query, list, export; ingester: also store and delete clips; admin: everything")
      ->required()
      ->type_name("ROLE")
      ->check(CLI::IsMember(roles));
  command.add_option("--database", options.database, "Restrict the token to this database")
      ->type_name("DB");
  const std::map<std::string, double> units = {
      {"s", 1}, {"m", 60}, {"h", 3600}, {"d", 86400}, {"w", 604800}};
  const auto has_unit = [](const std::string& text) -> std::string {
    double number = 0;
    if (!CLI::detail::lexical_cast(text, number)) return "";
    return fmt::format("expected a time with a unit (s, m, h, d, w), got {}; did you mean {}d?",
                       text, text);
  };
  command
      .add_option("--expires", options.lifetime_seconds, "Lifetime: 30d, 12h, 90m; else unlimited")
      ->type_name("TIME")
      // The last transformation is applied first.
      ->transform(CLI::AsNumberWithUnit(units, CLI::AsNumberWithUnit::UNIT_REQUIRED, "TIME"))
      ->transform(CLI::Validator(has_unit, ""))
      ->check(PositiveNumber());
  command.add_option("--description", options.description, "Purpose of the token")
      ->type_name("TEXT");
}

absl::Status RunCreate(const TokenCreateOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::CreateTokenRequest request;
  request.mutable_token()->set_role(options.role);
  if (!options.database.empty())
    request.mutable_token()->set_database(DatabaseName(options.database));
  if (options.lifetime_seconds > 0) {
    const double max_seconds = 1e10;  // more than the server accepts, without overflow
    *request.mutable_ttl() = google::protobuf::util::TimeUtil::MillisecondsToDuration(
        std::llround(std::min(options.lifetime_seconds, max_seconds) * 1000));
  }
  request.mutable_token()->set_description(options.description);
  const auto response = client->CreateToken(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
    return absl::OkStatus();
  }
  // Only the secret goes to standard output, so that it can be redirected into a file.
  fmt::print(stderr, "{}. Keep the following secret; it is not shown again.\n",
             text::DisplayText(TokenText(response->token())));
  PrintLineText(response->secret());
  return absl::OkStatus();
}

void DeclareList(CLI::App&, TokenListOptions&) {}

absl::Status RunList(const TokenListOptions&, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto tokens = client->AllTokens();
  if (!tokens.ok()) return tokens.status();
  PrintItems(
      *tokens, global,
      [](const std::vector<v1::Token>& all) { return TokensTable(all, std::time(nullptr)); },
      "no tokens; create one with `motiondb token create --role ROLE`");
  return absl::OkStatus();
}

void DeclareRevoke(CLI::App& command, TokenRevokeOptions& options) {
  command.add_option("TOKEN", options.token, "Name in `motiondb token list`")->required();
}

absl::Status RunRevoke(const TokenRevokeOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::RevokeTokenRequest request;
  request.set_name(TokenName(options.token));
  const auto response = client->RevokeToken(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintLine("revoked {}", response->token().name());
  }
  return absl::OkStatus();
}

}  // namespace

void AddTokenCommand(CommandLine line) {
  const CommandLine inner =
      AddCommandGroup(line, "token", "Create, list or revoke tokens",
                      "motiondb token create --role reader --expires 30d\nmotiondb token list");
  AddCommand<TokenCreateOptions>(inner, "create", "Create a token and print its secret, once",
                                 "motiondb token create --role reader --expires 30d\n"
                                 "motiondb token create --role ingester --database walks",
                                 DeclareCreate, RunCreate);
  AddCommand<TokenListOptions>(inner, "list", "List tokens, without their secrets",
                               "motiondb token list", DeclareList, RunList);
  AddCommand<TokenRevokeOptions>(inner, "revoke", "Revoke a token immediately",
                                 "motiondb token revoke 0123456789ab", DeclareRevoke, RunRevoke);
}

}  // namespace motiondb::client
