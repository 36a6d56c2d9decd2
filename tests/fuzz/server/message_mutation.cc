#include "tests/fuzz/server/message_mutation.h"

#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace motiondb::tests {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using Random = std::minstd_rand;

constexpr double kNumbers[] = {0,     1,    -1,    0.5,   0.1,  1e-3,   1e-9,  1e-300, 5e-324,
                               10,    60,   120,   1000,  1e6,  1e9,    1e18,  1e30,   1e300,
                               -1e18, -1e9, 0.016, 0.017, 3600, 1e-310, 65536, 255};
constexpr double kNone[] = {std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::quiet_NaN()};
constexpr std::int64_t kIntegers[] = {0,
                                      1,
                                      -1,
                                      2,
                                      3,
                                      10,
                                      100,
                                      1000,
                                      65536,
                                      1'000'000,
                                      std::numeric_limits<std::int32_t>::max(),
                                      std::numeric_limits<std::int32_t>::min(),
                                      std::numeric_limits<std::int64_t>::max(),
                                      std::numeric_limits<std::int64_t>::min()};
constexpr std::size_t kMaxGrowth = 64;  // growth of one text in bytes

template <typename Values>
auto OneOf(const Values& values, Random& random) {
  return values[random() % std::size(values)];
}

double Number(double now, Random& random) {
  switch (random() % 4) {
    case 0:
      return OneOf(kNone, random);
    case 1:
      return now * OneOf(kNumbers, random);
    default:
      return OneOf(kNumbers, random);
  }
}

std::int64_t Integer(std::int64_t now, Random& random) {
  if (random() % 3 > 0) return OneOf(kIntegers, random);
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(now) + random() % 7 - 3);
}

// Sometimes treats the text as packed floats and preserves their number.
std::string Text(std::string text, Random& random) {
  if (text.size() >= sizeof(float) && random() % 4 > 0) {
    const std::size_t at = random() % (text.size() / sizeof(float)) * sizeof(float);
    float value = 0;
    std::memcpy(&value, text.data() + at, sizeof(value));
    value = static_cast<float>(std::clamp(Number(value, random), -3e38, 3e38));
    if (random() % 8 == 0) value = std::numeric_limits<float>::quiet_NaN();
    if (random() % 8 == 0) value = std::numeric_limits<float>::infinity();
    std::memcpy(text.data() + at, &value, sizeof(value));
    return text;
  }
  const std::size_t size = text.size();
  text.resize(size + kMaxGrowth);
  text.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(text.data()), size, text.size()));
  return text;
}

class Mutation {
 public:
  explicit Mutation(Random& random) : random_(random) {}

  void Change(Message& message) {
    const auto& descriptor = *message.GetDescriptor();
    if (descriptor.field_count() == 0) return;
    const Reflection& reflection = *message.GetReflection();
    // Prefers fields that are set.
    std::vector<const FieldDescriptor*> set;
    reflection.ListFields(message, &set);
    const bool among_set = !set.empty() && random_() % 4 > 0;
    const FieldDescriptor* const field =
        among_set ? OneOf(set, random_)
                  : descriptor.field(static_cast<int>(random_() % descriptor.field_count()));
    if (field->is_repeated()) {
      ChangeList(message, *field);
    } else if (random_() % 16 == 0) {
      reflection.ClearField(&message, field);
    } else {
      ChangeOne(message, *field);
    }
  }

 private:
  void ChangeOne(Message& message, const FieldDescriptor& field) {
    const Reflection& r = *message.GetReflection();
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_INT32:
        return r.SetInt32(&message, &field,
                          static_cast<std::int32_t>(Integer(r.GetInt32(message, &field), random_)));
      case FieldDescriptor::CPPTYPE_INT64:
        return r.SetInt64(&message, &field, Integer(r.GetInt64(message, &field), random_));
      case FieldDescriptor::CPPTYPE_UINT32:
        return r.SetUInt32(&message, &field, static_cast<std::uint32_t>(Integer(0, random_)));
      case FieldDescriptor::CPPTYPE_UINT64:
        return r.SetUInt64(&message, &field, static_cast<std::uint64_t>(Integer(0, random_)));
      case FieldDescriptor::CPPTYPE_DOUBLE:
        return r.SetDouble(&message, &field, Number(r.GetDouble(message, &field), random_));
      case FieldDescriptor::CPPTYPE_FLOAT:
        return r.SetFloat(&message, &field, 0);
      case FieldDescriptor::CPPTYPE_BOOL:
        return r.SetBool(&message, &field, !r.GetBool(message, &field));
      case FieldDescriptor::CPPTYPE_ENUM:
        return r.SetEnumValue(&message, &field, static_cast<int>(random_() % 8));
      case FieldDescriptor::CPPTYPE_STRING:
        return r.SetString(&message, &field, Text(r.GetString(message, &field), random_));
      case FieldDescriptor::CPPTYPE_MESSAGE:
        return Change(*r.MutableMessage(&message, &field));
    }
  }

  void ChangeList(Message& message, const FieldDescriptor& field) {
    const Reflection& r = *message.GetReflection();
    const int size = r.FieldSize(message, &field);
    if (size > 0 && random_() % 4 == 0) return r.RemoveLast(&message, &field);
    const int i = size == 0 ? 0 : static_cast<int>(random_() % size);
    const bool add = size == 0 || random_() % 2 == 0;
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_DOUBLE: {
        const double value = Number(1, random_);
        return add ? r.AddDouble(&message, &field, value)
                   : r.SetRepeatedDouble(&message, &field, i, value);
      }
      case FieldDescriptor::CPPTYPE_STRING: {
        const std::string value =
            Text(size == 0 ? "" : r.GetRepeatedString(message, &field, i), random_);
        return add ? r.AddString(&message, &field, value)
                   : r.SetRepeatedString(&message, &field, i, value);
      }
      case FieldDescriptor::CPPTYPE_MESSAGE:
        return Change(add ? *r.AddMessage(&message, &field)
                          : *r.MutableRepeatedMessage(&message, &field, i));
      default:
        return;
    }
  }

  Random& random_;
};

}  // namespace

std::size_t MutateMessage(Message& message, std::uint8_t* data, std::size_t size,
                          std::size_t max_size, unsigned seed) {
  static const bool kQuiet = [] {  // texts that are not UTF-8 are expected
    google::protobuf::SetLogHandler(nullptr);
    return true;
  }();
  (void)kQuiet;
  Random random(seed);
  if (random() % 8 == 0 || !message.ParseFromArray(data, static_cast<int>(size))) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  Mutation mutation(random);
  for (unsigned changes = 1 + random() % 4; changes > 0; --changes) mutation.Change(message);
  std::string bytes;
  if (!message.SerializePartialToString(&bytes) || bytes.size() > max_size || bytes.empty()) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  std::memcpy(data, bytes.data(), bytes.size());
  return bytes.size();
}

}  // namespace motiondb::tests
