// The web page: files, caching, compression, security headers, and paths that must not reach other
// files.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "server/gateway/http_content.h"
#include "server/gateway/page_files.h"
#include "tests/server/gateway/web_client.h"
#include "tests/server/gateway/web_server.h"
#include "tests/support/captured_log.h"

namespace motiondb::tests::page_test {
namespace {

namespace fs = std::filesystem;

constexpr char kScript[] = "/assets/index-B5Qt9EMX.js";

class PageFolder {
 public:
  PageFolder() {
    Write("index.html", "<!doctype html><title>motiondb</title>");
    Write("assets/index-B5Qt9EMX.js", script_);
    Write("assets/index-B5Qt9EMX.js.gz", server::Gzip(script_));
    Write("logo.svg", "<svg xmlns='http://www.w3.org/2000/svg'/>");
  }

  void Write(const std::string& name, const std::string& content) {
    fs::create_directories(path(name).parent_path());
    std::ofstream(path(name), std::ios::binary) << content;
  }
  fs::path path(const std::string& name) const { return folder() / name; }
  fs::path folder() const { return outer_ / "web"; }
  const std::string& script() const { return script_; }
  // A server with this page.
  void Serve(WebServer& server) const {
    server->options().web_root = folder().string();
    server->Restart();
  }

 private:
  const TemporaryDirectory outer_;
  const std::string script_ = [] {
    std::string text;
    for (int i = 0; i < 30'000; ++i) text += "export const a" + std::to_string(i) + " = 1;\n";
    return text;
  }();
};

HttpReply Fetch(const std::string& address, const std::string& path, const Headers& headers = {},
                const std::string& method = "GET") {
  WebClient client(address);
  client.Send(HttpText(method, path, headers));
  return client.Read(method == "HEAD");
}

TEST_CASE("Page: files with type, length, tag and caching", "[server][gateway]") {
  const PageFolder page;
  WebServer server;
  page.Serve(server);
  const HttpReply index = Fetch(server.address(), "/index.html");
  CHECK(index.status == 200);
  CHECK(index.Field("content-type") == "text/html; charset=utf-8");
  CHECK(index.Field("cache-control") == "no-cache");
  CHECK(Fetch(server.address(), "/").body == index.body);
  CHECK(Fetch(server.address(), "/?a=b").body == index.body);
  CHECK(Fetch(server.address(), "/logo.svg").Field("content-type") == "image/svg+xml");
  const HttpReply script = Fetch(server.address(), kScript);
  CHECK(script.body == page.script());
  CHECK(script.Field("content-length") == std::to_string(page.script().size()));
  CHECK(script.Field("content-type") == "text/javascript; charset=utf-8");
  CHECK(script.Field("cache-control") == "public, max-age=31536000, immutable");
  CHECK(script.Field("content-encoding").empty());

  const HttpReply head = Fetch(server.address(), kScript, {}, "HEAD");
  CHECK(head.status == 200);
  CHECK(head.fields.at("content-length") == script.fields.at("content-length"));
  CHECK(head.Field("etag") == script.Field("etag"));
  CHECK(Fetch(server.address(), "/", {}, "POST").status == 404);
}

TEST_CASE("Page: a version that the client has is not sent again", "[server][gateway]") {
  const PageFolder page;
  WebServer server;
  page.Serve(server);
  const std::string tag = Fetch(server.address(), kScript).Field("etag");
  const std::string gzip_tag =
      Fetch(server.address(), kScript, {{"Accept-Encoding", "gzip"}}).Field("etag");
  CHECK(tag != gzip_tag);
  const auto status = [&](const std::string& tags) {
    WebClient client(server.address());
    client.Send(HttpText("GET", kScript, {{"If-None-Match", tags}}));
    const HttpReply reply = client.Read(true);
    if (reply.status == 304) CHECK(reply.Field("etag") == tag);
    return reply.status;
  };
  CHECK(status(tag) == 304);
  CHECK(status("\"a\", W/" + tag) == 304);
  CHECK(status("*") == 304);
  CHECK(status("\"a\"") == 200);
  CHECK(status(gzip_tag) == 200);
  CHECK(status(tag.substr(1)) == 200);
  // The connection can be used again after a 304 and after a long file.
  WebClient client(server.address());
  for (int i = 0; i < 3; ++i) {
    client.Send(HttpText("GET", kScript, {{"If-None-Match", tag}}));
    CHECK(client.Read(true).status == 304);
    client.Send(HttpText("GET", kScript, {}));
    CHECK(client.Read().body == page.script());
  }
}

TEST_CASE("Page: compressed files, if the client accepts them", "[server][gateway]") {
  const PageFolder page;
  WebServer server;
  page.Serve(server);
  for (const char* const accepted : {"gzip", "br, gzip;q=0.5", "GZIP"}) {
    const HttpReply reply = Fetch(server.address(), kScript, {{"Accept-Encoding", accepted}});
    CHECK(reply.Field("content-encoding") == "gzip");
    CHECK(reply.Field("vary") == "accept-encoding");
    CHECK(reply.Field("content-type") == "text/javascript; charset=utf-8");
    const auto plain = server::Gunzip(reply.body, [](auto) { return absl::OkStatus(); });
    REQUIRE(plain.ok());
    CHECK(*plain == page.script());
  }
  for (const char* const refused : {"br", "gzip;q=0", "identity"}) {
    const HttpReply reply = Fetch(server.address(), kScript, {{"Accept-Encoding", refused}});
    CHECK(reply.Field("content-encoding").empty());
    CHECK(reply.body == page.script());
  }
}

TEST_CASE("Page: paths of views give the page, others are not found", "[server][gateway]") {
  const PageFolder page;
  WebServer server;
  page.Serve(server);
  const std::string index = Fetch(server.address(), "/index.html").body;
  for (const char* const view : {"/clips", "/databases/demo/clips/walk", "/a/b/c?x=1.2"}) {
    CHECK(Fetch(server.address(), view).body == index);
  }
  for (const char* const none : {"/a.js", "/assets/none-12345678.js", "/wp-login.php",
                                 "/assets/index-B5Qt9EMX.js.gz", "/../index.html"}) {
    CHECK(Fetch(server.address(), none).status == 404);
  }
  // Calls stay calls.
  CHECK(Fetch(server.address(), "/motiondb.v1.DatabaseService/ListDatabases").status == 405);
  CHECK(Fetch(server.address(), "/openapi.json").Field("content-type") == "application/json");
}

TEST_CASE("Page: no request reaches other files", "[server][gateway]") {
  const PageFolder page;
  std::ofstream(page.folder().parent_path() / "secret.txt") << "SECRET";
  fs::create_symlink("../secret.txt", page.path("link.txt"));
  fs::create_directory_symlink("..", page.path("up"));
  WebServer server;
  page.Serve(server);
  for (const char* const path :
       {"/../secret.txt", "/assets/../../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt",
        "/link.txt", "/up/secret.txt", "//secret.txt", "/./../secret.txt", "/..\\secret.txt",
        "/assets/..;/../secret.txt", "/etc/passwd"}) {
    const HttpReply reply = Fetch(server.address(), path);
    CHECK(reply.body.find("SECRET") == std::string::npos);
    CHECK(reply.body.find("root:") == std::string::npos);
  }
  CHECK(Fetch(server.address(), "/link.txt").status == 404);
  CHECK(Fetch(server.address(), "/up/secret.txt").status == 404);
  // Files that come later are not served either.
  std::ofstream(page.path("late.txt")) << "late";
  CHECK(Fetch(server.address(), "/late.txt").status == 404);
}

TEST_CASE("Page: security headers on every answer", "[server][gateway]") {
  const PageFolder page;
  WebServer server;
  page.Serve(server);
  for (const char* const path : {"/", kScript, "/none.js", "/clips", "/session"}) {
    const HttpReply reply = Fetch(server.address(), path);
    const std::string policy = reply.Field("content-security-policy");
    CHECK(policy.starts_with("default-src 'none'; script-src 'self'; style-src 'self';"));
    CHECK(policy.find("unsafe") == std::string::npos);
    CHECK(policy.find("frame-ancestors 'none'") != std::string::npos);
    CHECK(reply.Field("x-content-type-options") == "nosniff");
    CHECK(reply.Field("referrer-policy") == "no-referrer");
    CHECK(reply.Field("cross-origin-opener-policy") == "same-origin");
  }
}

TEST_CASE("Page: without a page the HTTP API works, and the log says so", "[server][gateway]") {
  const TemporaryDirectory empty;
  WebServer server;
  const CapturedLog log(spdlog::level::info);
  server->options().web_root = empty / "web";
  server->Restart();
  const HttpReply reply = Fetch(server.address(), "/");
  CHECK(reply.status == 404);
  CHECK(reply.body.find("not installed") != std::string::npos);
  CHECK(Post(server.address(), "/motiondb.v1.DatabaseService/ListDatabases",
             {{"Content-Type", "application/json"}}, "{}")
            .status == 200);
  server->Stop();
  CHECK(log.text().find("web page not installed, HTTP API only") != std::string::npos);
}

TEST_CASE("PageFiles: limits", "[server][gateway]") {
  const PageFolder page;
  CHECK(server::PageFiles::Read(page.folder().string()).ok());
  CHECK(absl::IsNotFound(server::PageFiles::Read(page.path("none").string()).status()));
  CHECK(absl::IsNotFound(server::PageFiles::Read(page.path("index.html").string()).status()));
  fs::resize_file(page.path("logo.svg"), server::PageFiles::kMaxBytes);
  CHECK(absl::IsInvalidArgument(server::PageFiles::Read(page.folder().string()).status()));
  fs::resize_file(page.path("logo.svg"), 1);
  for (int i = 0; i <= server::PageFiles::kMaxFiles; ++i) {
    std::ofstream(page.path(std::to_string(i)));
  }
  CHECK(absl::IsInvalidArgument(server::PageFiles::Read(page.folder().string()).status()));
}

TEST_CASE("Page: a slow client of a large file holds little memory", "[server][gateway]") {
  // The client reads nothing for a while; the server sends the rest in blocks when it reads.
  PageFolder page;
  const std::string large(8 << 20, 'x');
  page.Write("large.txt", large);
  WebServer server;
  page.Serve(server);
  WebClient slow(server.address());
  slow.Send(HttpText("GET", "/large.txt", {}) + HttpText("GET", "/logo.svg", {}));
  CHECK(Fetch(server.address(), "/").status == 200);
  CHECK(slow.Read().body == large);
  CHECK(slow.Read().status == 200);
  WebClient gone(server.address());
  gone.Send(HttpText("GET", "/large.txt", {}));
  gone.Reset();
  CHECK(Fetch(server.address(), "/").status == 200);
}

}  // namespace
}  // namespace motiondb::tests::page_test
