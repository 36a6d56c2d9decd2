#include "client/grpc_status.h"

#include <fmt/format.h>
#include <motiondb/field_violation.h>
#include <motiondb/v1/error.pb.h>

#include <string>
#include <utility>

#include "absl/strings/cord.h"

namespace motiondb::client {
namespace {

// Any's type URL may have any prefix; what follows the last slash is the type.
constexpr char kBadRequestType[] = "/google.rpc.BadRequest";

bool IsBadRequest(const std::string& type_url) {
  const std::string type = kBadRequestType;
  return type_url.size() >= type.size() &&
         type_url.compare(type_url.size() - type.size(), type.size(), type) == 0;
}

void AppendViolations(const v1::BadRequest& bad_request, std::string& message) {
  const std::string said = message;
  for (const auto& violation : bad_request.field_violations()) {
    if (said.find(violation.description()) != std::string::npos) continue;
    fmt::format_to(std::back_inserter(message), "{}{}: {}", message.empty() ? "" : "; ",
                   violation.field(), violation.description());
  }
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
      if (IsBadRequest(detail.type_url()) && bad_request.ParseFromString(detail.value())) {
        violations.MergeFrom(bad_request);
      }
    }
  }
  AppendViolations(violations, message);
  // gRPC and absl number the canonical codes alike.
  absl::Status result(static_cast<absl::StatusCode>(status.error_code()), message);
  if (violations.field_violations_size() > 0) {
    result.SetPayload(kBadRequestTypeUrl, absl::Cord(violations.SerializeAsString()));
  }
  return result;
}

std::vector<FieldViolation> FieldViolations(const absl::Status& status) {
  std::vector<FieldViolation> result;
  const auto payload = status.GetPayload(kBadRequestTypeUrl);
  v1::BadRequest bad_request;
  if (!payload || !bad_request.ParseFromString(std::string(*payload))) return result;
  for (const auto& violation : bad_request.field_violations()) {
    result.push_back({violation.field(), violation.description()});
  }
  return result;
}

}  // namespace motiondb::client
