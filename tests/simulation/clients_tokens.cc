// Calls of the clients that create, use and revoke tokens.
#include <fmt/format.h>

#include "server/engine/work/clock.h"
#include "tests/simulation/clients.h"

namespace motiondb::simulation {

using server::Pool;
using server::TokenRegistry;

namespace {

// Until all servers refuse a revoked token: 2 s, of which a slow store may take the rest.
constexpr milliseconds kMaxRevocation{1750};

absl::Status IsEnding() { return absl::UnavailableError("the server ends"); }

}  // namespace

absl::Status Clients::MakeToken() {
  const auto made = Call<server::CreatedToken>(
      AnyServer(), Pool::kChanges,
      [this](const Request& request) -> absl::StatusOr<server::CreatedToken> {
        TokenRegistry* const tokens = cluster_.TokensOf(request.engine);
        if (tokens == nullptr) return IsEnding();
        return tokens->Make(storage::Role::kReader, "", "", server::NowMicroseconds(), 0, {},
                            request.cancelled);
      });
  if (made.ok()) tokens_.push_back({.id = made->record.id, .text = made->secret});
  return made.status();
}

absl::Status Clients::RevokeToken(int server) {
  if (tokens_.empty()) return absl::OkStatus();
  KnownToken& token = tokens_[World::Current().Below(tokens_.size())];
  token.may_be_revoked = true;
  return Call<storage::TokenRecord>(
             server, Pool::kChanges,
             [this, &token](const Request& request) -> absl::StatusOr<storage::TokenRecord> {
               TokenRegistry* const tokens = cluster_.TokensOf(request.engine);
               if (tokens == nullptr) return IsEnding();
               auto revoked = tokens->Revoke(token.id, server::NowMicroseconds(),
                                             {nullptr, request.cancelled});
               if (revoked.ok()) token.revoked_by = World::Current().process();
               return revoked;
             })
      .status();
}

absl::Status Clients::UseToken(int server, const KnownToken& token, bool is_revoked) {
  const auto use = [this, &token, is_revoked](const Request& request) -> absl::StatusOr<bool> {
    TokenRegistry* const tokens = cluster_.TokensOf(request.engine);
    if (tokens == nullptr) return IsEnding();
    World& world = World::Current();
    const bool was_revoked_here = token.revoked_by == world.process();
    const auto found = tokens->Find(token.text);
    if (!found.ok()) return found.status();
    const bool is_valid = *found != nullptr && (*found)->CheckValid(server::NowMicroseconds()).ok();
    if (!is_valid && !token.may_be_revoked) world.Fail("a server refuses a valid token");
    if (is_valid && (was_revoked_here || is_revoked)) {
      world.Fail("a server accepts a revoked token");
    }
    return is_valid;
  };
  return Call<bool>(server, Pool::kRequests, use).status();
}

absl::Status Clients::UseAnyToken() {
  if (tokens_.empty()) return absl::OkStatus();
  return UseToken(AnyServer(), tokens_[World::Current().Below(tokens_.size())], false);
}

void Clients::RevokeLastToken() {
  // Each change causes looks at the store, which must not put off what the servers do each second.
  for (const auto& [id, life] : history_.lives()) {
    if (life.is_deleted) continue;
    ++running_;
    const auto set_label = [this, database = life.name] {
      SetLabel(database, "last").IgnoreError();
      --running_;
    };
    World::Current().Start(nullptr, set_label, World::Current().Between({}, kMaxRevocation));
  }
  ++running_;
  World::Current().Start(nullptr, [this] {
    const auto use_all = [this](bool are_checked) {
      for (int server = 0; server < cluster_.size(); ++server) {
        for (const KnownToken& token : tokens_) {
          const bool is_revoked = are_checked && token.revoked_by != nullptr;
          UseToken(server, token, is_revoked).IgnoreError();
        }
      }
    };
    use_all(false);  // the servers then have all of them in memory
    RevokeToken(AnyServer()).IgnoreError();
    World::Current().Sleep(kMaxRevocation);
    use_all(true);
    --running_;
  });
}

}  // namespace motiondb::simulation
