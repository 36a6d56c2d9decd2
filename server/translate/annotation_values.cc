#include "server/translate/annotation_values.h"

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "server/translate/message_fields.h"
#include "text/display_text.h"

namespace motiondb::server {

absl::StatusOr<storage::FieldValue> ParseFieldValue(std::string_view field,
                                                    const v1::FieldValue& value) {
  switch (value.value_case()) {
    case v1::FieldValue::kText:
      return storage::FieldValue(value.text());
    case v1::FieldValue::kNumber:
      return storage::FieldValue(value.number());
    case v1::FieldValue::kFlag:
      return storage::FieldValue(value.flag());
    case v1::FieldValue::kTime: {
      constexpr std::int64_t kFirst = -62'135'596'800;  // of google.protobuf.Timestamp
      constexpr std::int64_t kLast = 253'402'300'799;
      const auto& time = value.time();
      if (time.seconds() < kFirst || time.seconds() > kLast || time.nanos() < 0 ||
          time.nanos() > 999'999'999) {
        return FieldViolation(field, "expected a time of the years 1 to 9999");
      }
      return storage::FieldValue(
          storage::FieldTime{time.seconds() * 1'000'000 + time.nanos() / 1000});
    }
    case v1::FieldValue::VALUE_NOT_SET:
      break;
  }
  return FieldViolation(field, "expected one of text, number, flag, time");
}

absl::StatusOr<storage::Fields> ParseFields(std::string_view field, const GivenFields& given) {
  storage::Fields fields;
  for (const auto& [name, value] : given) {
    const std::string path = fmt::format("{}[{}]", field, text::SafeText(name));
    MOTIONDB_ASSIGN_OR_RETURN(fields[name], ParseFieldValue(path, value));
  }
  return fields;
}

}  // namespace motiondb::server
