#include "server/http2/frame_guard.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>
#include <vector>

#include "tests/server/http2/http2_frame.h"

namespace motiondb::tests::frame_guard_test {
namespace {

using server::FrameGuard;

const FrameGuard::Clock::time_point kBegan = FrameGuard::Clock::now();

// Returns the bytes for libnghttp2 if the client's bytes arrive in pieces that end at `ends`.
std::string PassInPieces(FrameGuard& guard, const std::string& sent,
                         const std::vector<std::size_t>& ends) {
  std::string passed;
  std::size_t begin = 0;
  for (const std::size_t end : ends) {
    std::vector<std::uint8_t> buffer(8 + end - begin);
    const std::size_t kept_bytes = guard.Resume(buffer);
    std::copy(sent.begin() + static_cast<std::ptrdiff_t>(begin),
              sent.begin() + static_cast<std::ptrdiff_t>(end),
              buffer.begin() + static_cast<std::ptrdiff_t>(kept_bytes));
    const std::size_t size = guard.Pass(std::span(buffer).first(kept_bytes + end - begin));
    passed.append(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size));
    begin = end;
  }
  return passed;
}

std::string PassInOnePiece(const std::string& sent) {
  FrameGuard guard(kBegan);
  return PassInPieces(guard, sent, {sent.size()});
}

std::string Reset(int stream) { return Http2Frame(3, 0, stream, std::string("\0\0\0\x8", 4)); }

TEST_CASE("Frame guard: a reset of a stream that was never opened is ignored", "[server][http2]") {
  const std::string before = kHttp2Preface + kHttp2Settings + Http2Frame(1, 5, 5, "headers");
  const std::string after = Http2Frame(0, 1, 5, "data");
  const std::string ignored = Http2Frame('\xf0', 0, 7, std::string("\0\0\0\x8", 4));
  CHECK(PassInOnePiece(before + Reset(7) + after) == before + ignored + after);
  for (const int known : {1, 3, 5}) {
    CHECK(PassInOnePiece(before + Reset(known) + after) == before + Reset(known) + after);
  }
  // These are passed on, because no proper client sends them.
  for (const std::string& invalid :
       {Reset(0), Reset(8), Http2Frame(3, 0, 7, "x"), Http2Frame(8, 0, 7, "1234")}) {
    CHECK(PassInOnePiece(before + invalid) == before + invalid);
  }
  // A stream that is opened later can be reset then.
  const std::string opened = Http2Frame(1, 4, 9, "headers");
  CHECK(PassInOnePiece(before + Reset(9) + opened + Reset(9)).ends_with(opened + Reset(9)));
}

TEST_CASE("Frame guard: the result does not depend on the pieces in which bytes arrive",
          "[server][http2]") {
  std::mt19937 random(17);
  std::string sent = kHttp2Preface + kHttp2Settings;
  for (int i = 0; i < 200; ++i) {
    const char type = static_cast<char>(random() % 12);
    sent += type == 3
                ? Reset(static_cast<int>(random() % 40))
                : Http2Frame(type, static_cast<char>(random()), static_cast<int>(random() % 40),
                             std::string(random() % 30, 'x'));
  }
  const std::string whole = PassInOnePiece(sent);
  CHECK(whole.size() == sent.size());
  CHECK(whole != sent);
  for (int round = 0; round < 200; ++round) {
    std::vector<std::size_t> ends;
    for (std::size_t end = 0; end < sent.size();) {
      end = std::min<std::size_t>(sent.size(), end + 1 + random() % (round % 2 == 0 ? 3 : 60));
      ends.push_back(end);
    }
    FrameGuard guard(kBegan);
    REQUIRE(PassInPieces(guard, sent, ends) == whole);
  }
}

TEST_CASE("Frame guard: frames without a call are limited by calls and time", "[server][http2]") {
  using std::chrono::seconds;
  FrameGuard guard(kBegan);
  const auto pass = [&](const std::string& frame, int times) {
    std::string sent;
    for (int i = 0; i < times; ++i) sent += frame;
    PassInPieces(guard, sent, {sent.size()});
  };
  pass(kHttp2Preface, 1);
  pass(Http2Frame(6, 0, 0, "12345678"), 10'000);
  CHECK(!guard.TooMany(kBegan));
  pass(Http2Frame(9, 0, 1, ""), 1);
  CHECK(guard.TooMany(kBegan));
  CHECK(!guard.TooMany(kBegan + seconds(1)));
  pass(Http2Frame(0, 0, 1, ""), 7);  // empty DATA frames
  CHECK(guard.TooMany(kBegan));
  pass(Http2Frame(0, 0, 1, "x"), 1);
  CHECK(!guard.TooMany(kBegan));
  pass(Reset(99), 1);  // ignored frames count, too
  CHECK(guard.TooMany(kBegan));
}

}  // namespace
}  // namespace motiondb::tests::frame_guard_test
