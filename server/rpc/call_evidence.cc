#include "server/rpc/call_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <string_view>

#include "text/display_text.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kLongestRequestId = 128;

std::string Header(const grpc::CallbackServerContext& context, const char* name) {
  const auto& metadata = context.client_metadata();
  const auto found = metadata.find(name);
  return found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
}

bool IsPrintable(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c > 0x20 && c < 0x7f; });
}

// No secret, only unlikely to be met twice.
std::string NewRequestId() {
  thread_local std::mt19937_64 random{std::random_device{}()};
  return fmt::format("{:016x}", random());
}

}  // namespace

Evidence EvidenceOf(const grpc::CallbackServerContext& context, const std::string& address) {
  return {Header(context, "authorization"), Header(context, kCommonNameMetadata), address};
}

std::string PeerOf(const grpc::CallbackServerContext& context) {
  return Header(context, kPeerMetadata);
}

std::string AddressOf(const std::string& peer) {
  std::string_view text = peer;
  const std::size_t scheme = text.find(':');
  if (scheme == std::string_view::npos) return peer;
  if (text.substr(0, scheme) == "unix") return "unix";
  text.remove_prefix(scheme + 1);
  text = text.substr(0, text.rfind(':'));
  // Brackets come percent-encoded or not.
  for (const std::string_view open : {"%5B", "["}) {
    if (text.starts_with(open)) text.remove_prefix(open.size());
  }
  for (const std::string_view close : {"%5D", "]"}) {
    if (text.ends_with(close)) text.remove_suffix(close.size());
  }
  return std::string(text);
}

std::string RequestIdOf(const grpc::CallbackServerContext& context) {
  std::string given = Header(context, "x-request-id");
  const bool usable = !given.empty() && given.size() <= kLongestRequestId && IsPrintable(given) &&
                      text::WithoutSecrets(given) == given;
  return usable ? given : NewRequestId();
}

}  // namespace motiondb::server
