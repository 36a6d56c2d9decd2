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
#include <system_error>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/escaping.h"
#include "core/motion/error.h"
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

}  // namespace motiondb::server
