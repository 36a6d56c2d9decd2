#include "server/gateway/page_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/escaping.h"
#include "core/motion/error.h"
#include "server/gateway/http_content.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kGzipSuffix = ".gz";
constexpr std::size_t kTagBytes = 16;
constexpr std::size_t kNameHashLength = 8;  // in names of Vite: index-B5Qt9EMX.js

constexpr std::pair<std::string_view, std::string_view> kTypes[] = {
    {".css", "text/css; charset=utf-8"},
    {".html", "text/html; charset=utf-8"},
    {".ico", "image/x-icon"},
    {".jpg", "image/jpeg"},
    {".js", "text/javascript; charset=utf-8"},
    {".json", "application/json"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".png", "image/png"},
    {".svg", "image/svg+xml"},
    {".txt", "text/plain; charset=utf-8"},
    {".wasm", "application/wasm"},
    {".webmanifest", "application/manifest+json"},
    {".webp", "image/webp"},
    {".woff2", "font/woff2"},
};

std::string ContentTypeOf(const std::string& path) {
  const std::string extension = text::LowerCase(fs::path(path).extension().string());
  for (const auto& [known, type] : kTypes) {
    if (known == extension) return std::string(type);
  }
  return "application/octet-stream";
}

// Returns whether the path is that of a file whose name Vite makes from its content.
bool HasNameHash(const std::string& path) {
  if (!path.starts_with("/assets/")) return false;
  const std::string stem = fs::path(path).stem().string();
  return stem.size() > kNameHashLength && stem[stem.size() - kNameHashLength - 1] == '-';
}

std::string TagOf(std::string_view content) {
  char digest[EVP_MAX_MD_SIZE] = {};
  auto* const bytes = reinterpret_cast<unsigned char*>(digest);
  if (EVP_Digest(content.data(), content.size(), bytes, nullptr, EVP_sha256(), nullptr) != 1) {
    throw std::bad_alloc();
  }
  return absl::BytesToHexString({digest, kTagBytes});
}

// Reads a regular file of at most `max` bytes; does not follow a link.
absl::StatusOr<std::string> ReadPageFile(const fs::path& path, std::int64_t max) {
  const auto fault = [&] {
    return core::InvalidArgument("{}: {}", path.string(), strerror(errno));
  };
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0) return fault();
  const absl::Cleanup closing = [file] { close(file); };
  struct stat status {};
  if (fstat(file, &status) != 0) return fault();
  if (!S_ISREG(status.st_mode)) {
    return core::InvalidArgument("{}: expected a regular file", path.string());
  }
  if (status.st_size > max) {
    return core::InvalidArgument("{}: expected a web page of at most {} MiB, got more",
                                 path.string(), PageFiles::kMaxBytes >> 20);
  }
  std::string content(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t size = 0;
  while (size < content.size()) {
    const ssize_t got = read(file, content.data() + size, content.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fault();
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  content.resize(size);
  return content;
}

}  // namespace

absl::StatusOr<PageFiles> PageFiles::Read(const std::string& folder) {
  PageFiles page;
  std::error_code error;
  if (!fs::is_regular_file(fs::path(folder) / "index.html", error)) {
    return absl::NotFoundError(fmt::format("no file index.html in '{}'", folder));
  }
  std::map<std::string, std::string> compressed;  // by the path without suffix
  std::int64_t rest = kMaxBytes;
  int count = 0;
  auto entry = fs::recursive_directory_iterator(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const fs::file_status status = entry->symlink_status(error);
    if (error) break;
    if (status.type() != fs::file_type::regular) continue;
    if (++count > kMaxFiles) {
      return core::InvalidArgument("{}: expected a web page of at most {} files, got more", folder,
                                   kMaxFiles);
    }
    MOTIONDB_ASSIGN_OR_RETURN(std::string content, ReadPageFile(entry->path(), rest));
    rest -= static_cast<std::int64_t>(content.size());
    std::string path = "/" + entry->path().lexically_relative(folder).generic_string();
    if (path.ends_with(kGzipSuffix)) {
      path.resize(path.size() - kGzipSuffix.size());
      compressed[path] = std::move(content);
      continue;
    }
    PageFile& file = page.files_[path];
    file.type = ContentTypeOf(path);
    file.tag = TagOf(content);
    file.immutable = HasNameHash(path);
    file.content = std::move(content);
  }
  if (error) return core::InvalidArgument("{}: {}", folder, error.message());
  for (auto& [path, content] : compressed) {
    const auto found = page.files_.find(path);
    if (found != page.files_.end()) found->second.gzip = std::move(content);
  }
  // index.html may be a link.
  if (page.index() == nullptr) {
    return absl::NotFoundError(fmt::format("no file index.html in '{}'", folder));
  }
  return page;
}

const PageFile* PageFiles::Find(std::string_view path) const {
  const auto found = files_.find(path);
  return found == files_.end() ? nullptr : &found->second;
}

std::string InstalledPageFolder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return "";
  return (program.parent_path().parent_path() / "share/motiondb/web").string();
}

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
