#include "server/translate/field_violation.h"

#include "absl/strings/cord.h"
#include "motiondb/v1/error.pb.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

// gRPC carries details in a trailer of 8 KiB, together with the message.
constexpr std::size_t kDescriptionLimit = 1024;

void SetViolation(std::string_view field, std::string_view description, absl::Status& status) {
  v1::BadRequest bad_request;
  v1::BadRequest::FieldViolation& violation = *bad_request.add_field_violations();
  violation.set_field(std::string(field));
  violation.set_description(text::ValidUtf8(text::SafeText(description), kDescriptionLimit));
  status.SetPayload(kBadRequestUrl, absl::Cord(bad_request.SerializeAsString()));
}

}  // namespace

absl::Status FieldViolation(std::string_view field, std::string_view description) {
  absl::Status status = absl::InvalidArgumentError(fmt::format("{}: {}", field, description));
  SetViolation(field, description, status);
  return status;
}

absl::Status AtField(std::string_view field, absl::Status status) {
  if (!absl::IsInvalidArgument(status) && !absl::IsOutOfRange(status)) return status;
  if (status.GetPayload(kBadRequestUrl).has_value()) return status;
  SetViolation(field, std::string(status.message()), status);
  return status;
}

}  // namespace motiondb::server
