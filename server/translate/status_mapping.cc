#include "server/translate/status_mapping.h"

#include <string>

#include "absl/strings/cord.h"
#include "core/motion/error.h"
#include "motiondb/v1/error.pb.h"
#include "storage/store_url.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::server {

namespace {

// The trailer of gRPC with message and details has at most 8 KiB.
constexpr std::size_t kMessageLimit = 1024;

// A switch, although the numbers are equal, so that a new code on either side is handled
// explicitly.
grpc::StatusCode ToGrpcCode(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kOk:
      return grpc::StatusCode::OK;
    case absl::StatusCode::kCancelled:
      return grpc::StatusCode::CANCELLED;
    case absl::StatusCode::kUnknown:
      return grpc::StatusCode::UNKNOWN;
    case absl::StatusCode::kInvalidArgument:
      return grpc::StatusCode::INVALID_ARGUMENT;
    case absl::StatusCode::kDeadlineExceeded:
      return grpc::StatusCode::DEADLINE_EXCEEDED;
    case absl::StatusCode::kNotFound:
      return grpc::StatusCode::NOT_FOUND;
    case absl::StatusCode::kAlreadyExists:
      return grpc::StatusCode::ALREADY_EXISTS;
    case absl::StatusCode::kPermissionDenied:
      return grpc::StatusCode::PERMISSION_DENIED;
    case absl::StatusCode::kResourceExhausted:
      return grpc::StatusCode::RESOURCE_EXHAUSTED;
    case absl::StatusCode::kFailedPrecondition:
      return grpc::StatusCode::FAILED_PRECONDITION;
    case absl::StatusCode::kAborted:
      return grpc::StatusCode::ABORTED;
    case absl::StatusCode::kOutOfRange:
      return grpc::StatusCode::OUT_OF_RANGE;
    case absl::StatusCode::kUnimplemented:
      return grpc::StatusCode::UNIMPLEMENTED;
    case absl::StatusCode::kInternal:
      return grpc::StatusCode::INTERNAL;
    case absl::StatusCode::kUnavailable:
      return grpc::StatusCode::UNAVAILABLE;
    case absl::StatusCode::kDataLoss:
      return grpc::StatusCode::DATA_LOSS;
    case absl::StatusCode::kUnauthenticated:
      return grpc::StatusCode::UNAUTHENTICATED;
    default:
      return grpc::StatusCode::UNKNOWN;
  }
}

// Adds the field of an error as google.rpc.BadRequest. Its description is the message without the
// field.
void AddFieldViolation(const absl::Status& status, const std::string& field, v1::Status& details) {
  std::string_view description(status.message().data(), status.message().size());
  if (description.starts_with(field + ": ")) description.remove_prefix(field.size() + 2);
  v1::BadRequest bad_request;
  v1::BadRequest::FieldViolation& violation = *bad_request.add_field_violations();
  violation.set_field(field);
  violation.set_description(text::ValidUtf8(text::SafeText(description), kMessageLimit));
  google::protobuf::Any& detail = *details.add_details();
  detail.set_type_url("type.googleapis.com/google.rpc.BadRequest");
  detail.set_value(bad_request.SerializeAsString());
}

constexpr char kErrorInfoUrl[] = "type.googleapis.com/google.rpc.ErrorInfo";

void AddErrorInfo(v1::ErrorInfo info, v1::Status& details) {
  info.set_domain("motiondb");
  google::protobuf::Any& detail = *details.add_details();
  detail.set_type_url(kErrorInfoUrl);
  detail.set_value(info.SerializeAsString());
}

// The reason of an error: its own, or else the name of its code.
std::string ReasonOf(const absl::Status& status) {
  const auto reason = status.GetPayload(core::kReasonUrl);
  if (reason.has_value()) return std::string(*reason);
  if (status.GetPayload(core::kFieldUrl).has_value()) return "INVALID_FIELD";
  return absl::StatusCodeToString(status.code());
}

std::string RetryInfoOf(std::chrono::milliseconds delay) {
  v1::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(delay.count() / 1000);
  retry.mutable_retry_delay()->set_nanos(static_cast<int>(delay.count() % 1000) * 1'000'000);
  return retry.SerializeAsString();
}

// Until the store tries to connect again.
constexpr std::chrono::milliseconds kUnreachableDelay{1000};

bool IsMetadata(absl::string_view url) {
  return std::string_view(url.data(), url.size()).starts_with(core::kMetadataUrl);
}

v1::ErrorInfo ErrorInfoOf(const absl::Status& status) {
  v1::ErrorInfo info;
  info.set_reason(ReasonOf(status));
  status.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
    if (!IsMetadata(url)) return;
    url.remove_prefix(core::kMetadataUrl.size());
    (*info.mutable_metadata())[std::string(url)] = std::string(payload);
  });
  return info;
}

}  // namespace

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  v1::Status details;
  details.set_code(ToGrpcCode(status.code()));
  details.set_message(
      text::ValidUtf8(text::SafeText(std::string(status.message())), kMessageLimit));
  AddErrorInfo(ErrorInfoOf(status), details);
  status.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
    if (url == core::kReasonUrl || IsMetadata(url)) return;
    if (url == core::kFieldUrl) return AddFieldViolation(status, std::string(payload), details);
    google::protobuf::Any& detail = *details.add_details();
    detail.set_type_url(std::string(url));
    detail.set_value(std::string(payload));
  });
  if (ReasonOf(status) == storage::kStoreUnreachable) {
    google::protobuf::Any& detail = *details.add_details();
    detail.set_type_url(kRetryInfoUrl);
    detail.set_value(RetryInfoOf(kUnreachableDelay));
  }
  return {ToGrpcCode(status.code()), details.message(), details.SerializeAsString()};
}

absl::Status FromGrpcStatus(const grpc::Status& status) {
  absl::Status converted(static_cast<absl::StatusCode>(status.error_code()),
                         status.error_message());
  v1::Status details;
  if (!details.ParseFromString(status.error_details())) return converted;
  for (const google::protobuf::Any& detail : details.details()) {
    if (detail.type_url() == kRequestInfoUrl) continue;  // the call here has its own
    if (detail.type_url() != kErrorInfoUrl) {
      converted.SetPayload(detail.type_url(), absl::Cord(detail.value()));
      continue;
    }
    v1::ErrorInfo info;
    if (!info.ParseFromString(detail.value())) continue;
    converted.SetPayload(core::kReasonUrl, absl::Cord(info.reason()));
    for (const auto& [key, value] : info.metadata()) {
      converted.SetPayload(std::string(core::kMetadataUrl) + key, absl::Cord(value));
    }
  }
  return converted;
}

absl::Status RetryLater(std::chrono::milliseconds delay, std::string_view message) {
  absl::Status status = absl::ResourceExhaustedError(std::string(message));
  status.SetPayload(kRetryInfoUrl, absl::Cord(RetryInfoOf(delay)));
  return status;
}

grpc::Status WithRequestInfo(const grpc::Status& error, const std::string& request_id) {
  v1::Status details;
  // Existing details come from ToGrpcStatus. Without details, set code and message.
  if (error.error_details().empty() || !details.ParseFromString(error.error_details())) {
    details.set_code(error.error_code());
    details.set_message(error.error_message());
    v1::ErrorInfo info;
    info.set_reason(absl::StatusCodeToString(static_cast<absl::StatusCode>(error.error_code())));
    AddErrorInfo(std::move(info), details);
  }
  v1::RequestInfo info;
  info.set_request_id(request_id);
  google::protobuf::Any& detail = *details.add_details();
  detail.set_type_url(kRequestInfoUrl);
  detail.set_value(info.SerializeAsString());
  return {error.error_code(), error.error_message(), details.SerializeAsString()};
}

}  // namespace motiondb::server
