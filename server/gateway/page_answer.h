// Answers to requests for the web page: files with their caching, and index.html for the paths of
// views.
#pragma once

#include <memory>
#include <variant>

#include "server/gateway/page_files.h"
#include "server/http1/http_exchange.h"

namespace motiondb::server {

// Adds the headers that restrict what a page from this server may do: content from this server
// only, no inline code, no frames.
void AddPageSecurity(HttpFields& fields);

// Returns whether a request is for the page: GET or HEAD, and not the path of an RPC.
bool IsPageRequest(const HttpRequest& request);

// Returns the answer. An unknown path gives index.html, so that the address of a view can be
// shared, unless its last part has an extension (404). Large
// files are sent in blocks. `page` must outlive the answer.
std::variant<HttpResponse, std::shared_ptr<HttpWork>> AnswerPageRequest(
    const PageFiles& page, const HttpRequest& request,
    const std::shared_ptr<HttpExchange>& exchange);

}  // namespace motiondb::server
