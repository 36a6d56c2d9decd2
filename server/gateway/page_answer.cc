#include "server/gateway/page_answer.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/gateway/header_value.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kBlockBytes = 64 << 10;
constexpr std::string_view kRpcPrefix = "/motiondb.v1.";
constexpr char kPolicy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

HttpResponse NotFound(std::string reason) {
  HttpResponse response{
      .status = 404,
      .fields = {{"content-type", "text/plain; charset=utf-8"}, {"cache-control", "no-store"}},
      .body = std::move(reason) + "\n"};
  AddPageSecurity(response.fields);
  return response;
}

bool HasExtension(std::string_view path) {
  return path.substr(path.rfind('/') + 1).find('.') != std::string_view::npos;
}

// Returns whether the client has this version: If-None-Match names it, or any (RFC 9110, section
// 13.1.2). The comparison is weak.
bool HasVersion(std::string_view list, std::string_view tag) {
  while (!list.empty()) {
    std::string_view item = TakeItem(list, ',');
    if (item.starts_with("W/")) item.remove_prefix(2);
    if (item == tag || item == "*") return true;
  }
  return false;
}

// Sends a file in blocks. Each block follows when the socket has accepted the one before.
class PageTransfer final : public HttpWork {
 public:
  PageTransfer(std::shared_ptr<HttpExchange> exchange, HttpResponse head, std::string_view content,
               bool sends_content)
      : exchange_(std::move(exchange)),
        head_(std::move(head)),
        content_(content),
        sends_content_(sends_content) {}

  std::optional<HttpResponse> Admit(std::int64_t body_bytes) override {
    if (body_bytes == 0) return std::nullopt;
    return HttpResponse{.status = 413,
                        .fields = {{"content-type", "text/plain; charset=utf-8"}},
                        .body = "expected a request without a body\n"};
  }

  void Start(std::string /*body*/) override {
    exchange_->BeginStream(std::move(head_), content_.size());
    if (!sends_content_ || content_.empty()) return exchange_->EndStream();
    SendBlock();
  }

  void OnSent() override { SendBlock(); }

  void Cancel() override {}

 private:
  void SendBlock() {
    const std::string_view block = content_.substr(0, kBlockBytes);
    content_.remove_prefix(block.size());
    exchange_->SendPart(std::string(block));
    if (content_.empty()) exchange_->EndStream();
  }

  const std::shared_ptr<HttpExchange> exchange_;
  HttpResponse head_;
  std::string_view content_;  // not sent yet
  const bool sends_content_;
};

}  // namespace

void AddPageSecurity(HttpFields& fields) {
  fields.emplace_back("content-security-policy", kPolicy);
  fields.emplace_back("x-content-type-options", "nosniff");
  fields.emplace_back("referrer-policy", "no-referrer");
  fields.emplace_back("cross-origin-opener-policy", "same-origin");
  fields.emplace_back("cross-origin-resource-policy", "same-origin");
}

bool IsPageRequest(const HttpRequest& request) {
  return (request.method == "GET" || request.method == "HEAD") &&
         !request.path.starts_with(kRpcPrefix);
}

std::variant<HttpResponse, std::shared_ptr<HttpWork>> AnswerPageRequest(
    const PageFiles& page, const HttpRequest& request,
    const std::shared_ptr<HttpExchange>& exchange) {
  const PageFile* file = page.Find(request.path);
  if (file == nullptr && page.index() == nullptr) {
    return NotFound("the web page is not installed; the HTTP API works without it");
  }
  if (file == nullptr && HasExtension(request.path)) return NotFound("no such file");
  if (file == nullptr) file = page.index();
  const bool compressed = !file->gzip.empty() && AcceptsGzip(request.Find("accept-encoding"));
  const std::string tag = fmt::format("\"{}{}\"", file->tag, compressed ? "-gzip" : "");
  HttpResponse head;
  head.fields = {
      {"etag", tag},
      {"cache-control", file->immutable ? "public, max-age=31536000, immutable" : "no-cache"}};
  if (!file->gzip.empty()) head.fields.emplace_back("vary", "accept-encoding");
  AddPageSecurity(head.fields);
  if (HasVersion(request.Find("if-none-match"), tag)) {
    head.status = 304;
    return head;
  }
  head.fields.emplace_back("content-type", file->type);
  if (compressed) head.fields.emplace_back("content-encoding", "gzip");
  return std::make_shared<PageTransfer>(
      exchange, std::move(head), compressed ? file->gzip : file->content, request.method == "GET");
}

}  // namespace motiondb::server
