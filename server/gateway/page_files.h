// The built web page (client/web/dist) in memory, and answers to requests for it: files with their
// caching, and index.html for the paths of views. Only files found at the start are served, so no
// path of a request reaches the file system.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "absl/status/statusor.h"
#include "server/http1/http_exchange.h"

namespace motiondb::server {

struct PageFile {
  std::string content;
  std::string gzip;        // compressed content; empty: none
  std::string type;        // Content-Type
  std::string tag;         // hexadecimal digits of a hash of the content
  bool immutable = false;  // its name contains a hash of its content
};

// Thread-safe: it does not change.
class PageFiles {
 public:
  static constexpr std::int64_t kMaxBytes = 64 << 20;  // of all files together
  static constexpr int kMaxFiles = 2000;

  // Without files.
  PageFiles() = default;

  // Reads all files of the folder; NAME.gz is the compressed form of NAME. Ignores links and
  // special files in it. Errors: NOT_FOUND if there is no file index.html in it; INVALID_ARGUMENT
  // if a file cannot be read, or if the files exceed a limit.
  static absl::StatusOr<PageFiles> Read(const std::string& folder);

  // Returns the file of a path that begins with '/'; null if there is none.
  const PageFile* Find(std::string_view path) const;
  const PageFile* index() const { return Find("/index.html"); }

 private:
  std::map<std::string, PageFile, std::less<>> files_;  // by path
};

// Returns the folder of the page that is installed with this program: ../share/motiondb/web of the
// program's folder.
std::string InstalledPageFolder();

// Adds the headers that restrict what a page from this server may do: content from this server
// only, no inline code, no frames.
void AddPageSecurity(HttpFields& fields);

// Returns whether a request is for the page: GET or HEAD, and not the path of an RPC.
bool IsPageRequest(const HttpRequest& request);

// Returns the answer. An unknown path gives index.html, so that the address of a view can be
// shared, unless its last part has an extension (404). Large files are sent in blocks. `page` must
// outlive the answer.
std::variant<HttpResponse, std::shared_ptr<HttpWork>> AnswerPageRequest(
    const PageFiles& page, const HttpRequest& request,
    const std::shared_ptr<HttpExchange>& exchange);

}  // namespace motiondb::server
