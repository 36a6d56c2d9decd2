#include "tests/fuzz/server/answer_properties.h"

#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/fuzz/support/properties.h"

namespace motiondb::tests {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

void HoldsNumber(const FieldDescriptor& field, double number) {
  const bool is_log = field.name().starts_with("log_");
  const bool is_valid = is_log ? !std::isnan(number) && number < INFINITY : std::isfinite(number);
  if (!is_valid) std::fprintf(stderr, "%s: %g\n", field.full_name().c_str(), number);
  CheckContract(is_valid, "an answer's numbers are finite");
}

}  // namespace

void CheckAllFinite(const Message& answer) {
  const auto& reflection = *answer.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(answer, &fields);
  for (const FieldDescriptor* const field : fields) {
    const int count = field->is_repeated() ? reflection.FieldSize(answer, field) : 1;
    for (int i = 0; i < count; ++i) {
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
        HoldsNumber(*field, field->is_repeated() ? reflection.GetRepeatedDouble(answer, field, i)
                                                 : reflection.GetDouble(answer, field));
      } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        CheckAllFinite(field->is_repeated() ? reflection.GetRepeatedMessage(answer, field, i)
                                            : reflection.GetMessage(answer, field));
      }
    }
  }
}

void CheckRefusalContract(const absl::Status& status) {
  if (status.ok()) return;
  const bool expected = absl::IsInvalidArgument(status) || absl::IsOutOfRange(status) ||
                        absl::IsNotFound(status) || absl::IsFailedPrecondition(status) ||
                        absl::IsResourceExhausted(status);
  if (!expected) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  CheckContract(expected, "a query fails only by the client's fault or a limit");
  CheckContract(!status.message().empty(), "an error has a message");
}

}  // namespace motiondb::tests
