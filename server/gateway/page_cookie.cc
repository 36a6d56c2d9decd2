#include "server/gateway/page_cookie.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>

#include "absl/strings/escaping.h"
#include "core/motion/error.h"
#include "server/gateway/http_content.h"
#include "server/http2/grpc_wire.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr char kCookie[] = "motiondb_token";
constexpr char kHostCookie[] = "__Host-motiondb_token";
constexpr std::string_view kHttps = "https://";
constexpr std::string_view kHttp = "http://";

// Returns the token of the first cookie with this name; nullopt if there is none or it is no token.
std::optional<std::string> FindCookie(const HttpRequest& request, std::string_view name) {
  for (const auto& [field, value] : request.fields) {
    if (field != "cookie") continue;
    for (std::string_view pairs = value; !pairs.empty();) {
      const std::string_view pair = TakeItem(pairs, ';');
      if (pair.substr(0, pair.find('=')) != name || pair.size() <= name.size()) continue;
      std::string token;
      const std::string_view text = pair.substr(name.size() + 1);
      if (!absl::WebSafeBase64Unescape({text.data(), text.size()}, &token)) return std::nullopt;
      token = PrintableAscii(token);
      if (token.empty()) return std::nullopt;
      return token;
    }
  }
  return std::nullopt;
}

const char* CookieName(bool https) { return https ? kHostCookie : kCookie; }

std::string CookieText(std::string_view value, bool https, std::string_view more) {
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict{}{}", CookieName(https), value,
                     https ? "; Secure" : "", more);
}

absl::Status ForeignRequest(std::string_view reason) {
  return core::WithReason("CROSS_SITE_REQUEST", absl::PermissionDeniedError(std::string(reason)));
}

}  // namespace

bool UsesHttps(const HttpRequest& request, bool has_tls) {
  return has_tls || text::LowerCase(request.Find("origin")).starts_with(kHttps);
}

std::string TokenInCookie(const HttpRequest& request, bool has_tls) {
  if (auto token = FindCookie(request, kHostCookie)) return *std::move(token);
  if (has_tls) return "";
  return FindCookie(request, kCookie).value_or("");
}

std::string SetTokenCookie(const std::string& token, bool https) {
  return CookieText(absl::WebSafeBase64Escape(token), https, "");
}

void DeleteTokenCookie(HttpFields& fields) {
  for (const bool https : {false, true}) {
    fields.emplace_back("set-cookie", CookieText("", https, "; Max-Age=0"));
  }
}

absl::Status CheckSameOrigin(const HttpRequest& request, bool has_tls) {
  const std::string_view site = request.Find("sec-fetch-site");
  if (!site.empty() && site != "same-origin") {
    return ForeignRequest(
        fmt::format("expected a request of this server's page (Sec-Fetch-Site: same-origin), got "
                    "'{}'; use a token in the header Authorization instead of the cookie",
                    PrintableAscii(site)));
  }
  const std::string origin = text::LowerCase(request.Find("origin"));
  if (origin.empty()) return absl::OkStatus();
  const std::string host = text::LowerCase(request.Find("host"));
  const bool is_same = origin == fmt::format("{}{}", kHttps, host) ||
                       (!has_tls && origin == fmt::format("{}{}", kHttp, host));
  if (host.empty() || !is_same) {
    return ForeignRequest(fmt::format(
        "expected a request of this server's page, got the Origin '{}' for the Host '{}'; a proxy "
        "must pass the Host of the browser on",
        PrintableAscii(origin), PrintableAscii(host)));
  }
  return absl::OkStatus();
}

absl::Status AuthorizeByCookie(const HttpRequest& head, bool has_tls, ConnectRequest& request) {
  if (!head.Find("authorization").empty()) return absl::OkStatus();
  const std::string token = TokenInCookie(head, has_tls);
  if (token.empty()) return absl::OkStatus();
  MOTIONDB_RETURN_IF_ERROR(CheckSameOrigin(head, has_tls));
  if (head.Find("connect-protocol-version").empty()) {
    return ForeignRequest("a call with a cookie needs the header Connect-Protocol-Version: 1");
  }
  request.authorization = fmt::format("Bearer {}", token);
  return absl::OkStatus();
}

}  // namespace motiondb::server
