// The cookie in which a browser keeps the token of its user. Scripts of the page cannot read it,
// and other sites do not cause it to be sent (SameSite=Strict).
#pragma once

#include <string>

#include "absl/status/status.h"
#include "server/gateway/connect_request.h"
#include "server/http1/http_exchange.h"

namespace motiondb::server {

// Returns whether the browser reached the page by HTTPS: the server has TLS, or the header
// Origin shows that a proxy in front of it has.
bool UsesHttps(const HttpRequest& request, bool has_tls);

// Returns the token of the cookie; empty: none. Over HTTPS only a cookie with the prefix `__Host-`
// counts, which other hosts and plain HTTP cannot set.
std::string TokenInCookie(const HttpRequest& request, bool has_tls);

// Returns the value of Set-Cookie that stores the token, until the browser ends.
std::string SetTokenCookie(const std::string& token, bool https);
// Adds Set-Cookie headers that delete both cookies, of HTTP and of HTTPS: behind a proxy with TLS,
// some requests do not show how the browser reached the page.
void DeleteTokenCookie(HttpFields& fields);

// Returns PERMISSION_DENIED if the browser reports that a page of another origin makes the request
// (headers Origin and Sec-Fetch-Site). Clients that are no browsers do not send these headers.
absl::Status CheckSameOrigin(const HttpRequest& request, bool has_tls);

// Authorizes a call without the header Authorization by the cookie, if there is one. Returns
// PERMISSION_DENIED if a page of another site could have made the call: it is not of the same
// origin, or lacks the header Connect-Protocol-Version.
absl::Status AuthorizeByCookie(const HttpRequest& head, bool has_tls, ConnectRequest& request);

}  // namespace motiondb::server
