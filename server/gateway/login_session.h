// The login of the web page: POST /login, POST /logout and GET /session. A login checks a token as
// calls do, and stores it in a cookie (page_cookie.h); the server keeps no sessions.
#pragma once

#include <memory>
#include <variant>

#include "server/http1/http_exchange.h"

namespace motiondb::server {

struct ServiceContext;
class ThreadPool;

// What requests of sessions need. It must outlive them.
struct SessionContext {
  ServiceContext& host;
  ThreadPool& thread;  // tokens are read from the store
  bool has_tls = false;
};

bool IsSessionRequest(const HttpRequest& request);

// Returns the answer, JSON:
// - /session: whether tokens are needed, and the caller: name, role, database. 200 also without a
//   valid token.
// - /login, a body {"token": "..."}: the same, and the cookie. Errors: those of
//   AccessControl::Authenticate, PERMISSION_DENIED for a page of another origin, INVALID_ARGUMENT.
//   The audit log gets an entry.
// - /logout: deletes the cookie. PERMISSION_DENIED for a page of another origin.
std::variant<HttpResponse, std::shared_ptr<HttpWork>> AnswerSessionRequest(
    const SessionContext& context, const HttpRequest& request,
    const std::shared_ptr<HttpExchange>& exchange);

}  // namespace motiondb::server
