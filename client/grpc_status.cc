#include "client/grpc_status.h"

#include <fmt/format.h>
#include <motiondb/call_error.h>
#include <motiondb/field_violation.h>
#include <motiondb/v1/error.pb.h>

#include <string>
#include <utility>

#include "absl/strings/cord.h"

namespace motiondb::client {
namespace {

// Any's type URL may have any prefix; what follows the last slash is the type.
bool IsOfType(const google::protobuf::Any& any, absl::string_view url) {
  const std::string type(url.substr(url.rfind('/')));
  const std::string& given = any.type_url();
  return given.size() >= type.size() &&
         given.compare(given.size() - type.size(), type.size(), type) == 0;
}

void AppendViolations(const v1::BadRequest& bad_request, std::string& message) {
  const std::string said = message;
  for (const auto& violation : bad_request.field_violations()) {
    if (said.find(violation.description()) != std::string::npos) continue;
    fmt::format_to(std::back_inserter(message), "{}{}: {}", message.empty() ? "" : "; ",
                   violation.field(), violation.description());
  }
}

// What the message says whole, of what was asked for: nobody needs the server's log for it.
bool IsAboutTheRequest(absl::StatusCode code) {
  return code == absl::StatusCode::kInvalidArgument || code == absl::StatusCode::kNotFound ||
         code == absl::StatusCode::kAlreadyExists || code == absl::StatusCode::kOutOfRange ||
         code == absl::StatusCode::kFailedPrecondition;
}

// The payload under `url` as a message; false where there is none.
template <typename Message>
bool Payload(const absl::Status& status, absl::string_view url, Message& message) {
  const auto payload = status.GetPayload(url);
  return payload.has_value() && message.ParseFromString(std::string(*payload));
}

}  // namespace

absl::Status FromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  std::string message = status.error_message();
  v1::BadRequest violations;
  v1::Status details;
  if (details.ParseFromString(status.error_details())) {
    for (const auto& detail : details.details()) {
      v1::BadRequest bad_request;
      if (IsOfType(detail, kBadRequestTypeUrl) && bad_request.ParseFromString(detail.value())) {
        violations.MergeFrom(bad_request);
      }
    }
  }
  AppendViolations(violations, message);
  // gRPC and absl number the canonical codes alike.
  absl::Status result(static_cast<absl::StatusCode>(status.error_code()), message);
  for (const auto& detail : details.details()) {
    for (const absl::string_view url : {kRequestInfoTypeUrl, kRetryInfoTypeUrl}) {
      if (IsOfType(detail, url)) result.SetPayload(url, absl::Cord(detail.value()));
    }
  }
  if (violations.field_violations_size() > 0) {
    result.SetPayload(kBadRequestTypeUrl, absl::Cord(violations.SerializeAsString()));
  }
  const std::string request_id = RequestId(result);
  if (request_id.empty() || IsAboutTheRequest(result.code())) return result;
  return WithMessage(result, fmt::format("{} (request {})", message, request_id));
}

absl::Status WithRequestId(absl::Status status, const std::string& request_id) {
  v1::RequestInfo info;
  info.set_request_id(request_id);
  status.SetPayload(kRequestInfoTypeUrl, absl::Cord(info.SerializeAsString()));
  return status;
}

absl::Status WithMessage(const absl::Status& status, const std::string& message) {
  absl::Status result(status.code(), message);
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { result.SetPayload(url, payload); });
  return result;
}

std::string RequestId(const absl::Status& status) {
  v1::RequestInfo info;
  return Payload(status, kRequestInfoTypeUrl, info) ? info.request_id() : "";
}

std::optional<std::chrono::milliseconds> RetryDelay(const absl::Status& status) {
  v1::RetryInfo info;
  if (!Payload(status, kRetryInfoTypeUrl, info)) return std::nullopt;
  return std::chrono::milliseconds(info.retry_delay().seconds() * 1000 +
                                   info.retry_delay().nanos() / 1'000'000);
}

std::vector<FieldViolation> FieldViolations(const absl::Status& status) {
  std::vector<FieldViolation> result;
  v1::BadRequest bad_request;
  if (!Payload(status, kBadRequestTypeUrl, bad_request)) return result;
  for (const auto& violation : bad_request.field_violations()) {
    result.push_back({violation.field(), violation.description()});
  }
  return result;
}

}  // namespace motiondb::client
