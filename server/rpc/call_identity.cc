#include "server/rpc/call_identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <string_view>

#include "absl/strings/ascii.h"
#include "text/display_text.h"

namespace motiondb::server {

Method FindMethod(const google::protobuf::Descriptor& request_type) {
  const google::protobuf::DescriptorPool& pool = *request_type.file()->pool();
  for (const CallRule& rule : CallRules()) {
    const std::string name(rule.method);
    const auto* const method = pool.FindMethodByName("motiondb.v1." + name);
    if (method == nullptr || method->input_type() != &request_type) continue;
    return {.name = name,
            .rule = &rule,
            .streaming = method->client_streaming() || method->server_streaming(),
            .waits = request_type.FindFieldByName("timeout") != nullptr,
            .request_class = rule.request_class,
            .pool = rule.pool};
  }
  return {.name = request_type.name()};
}

std::vector<std::string> MethodNames() {
  std::vector<std::string> names;
  for (const CallRule& rule : CallRules()) names.emplace_back(rule.method);
  return names;
}

namespace {

constexpr std::size_t kMaxRequestIdLength = 128;

std::string Header(const grpc::CallbackServerContext& context, const char* name) {
  const auto& metadata = context.client_metadata();
  const auto found = metadata.find(name);
  return found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
}

// Not secret; unique with high probability.
std::string NewRequestId() {
  thread_local std::mt19937_64 random{std::random_device{}()};
  return fmt::format("{:016x}", random());
}

}  // namespace

PeerCredentials PeerCredentialsOf(const grpc::CallbackServerContext& context,
                                  const std::string& address) {
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
  // Brackets may be percent-encoded.
  for (const std::string_view open : {"%5B", "["}) {
    if (text.starts_with(open)) text.remove_prefix(open.size());
  }
  for (const std::string_view close : {"%5D", "]"}) {
    if (text.ends_with(close)) text.remove_suffix(close.size());
  }
  return std::string(text);
}

std::string UsableRequestId(const std::string& sent_id) {
  const bool usable = !sent_id.empty() && sent_id.size() <= kMaxRequestIdLength &&
                      std::ranges::all_of(sent_id, absl::ascii_isgraph) &&
                      text::RedactSecrets(sent_id) == sent_id;
  return usable ? sent_id : NewRequestId();
}

std::string RequestIdOf(const grpc::CallbackServerContext& context) {
  return UsableRequestId(Header(context, "x-request-id"));
}

}  // namespace motiondb::server
