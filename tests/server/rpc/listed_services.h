// Names of services by gRPC reflection, and their health. The messages are encoded by hand, because
// the packages of this system do not include them.
#pragma once

#include <google/protobuf/unknown_field_set.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/raw_call.h"
#include "tests/support/test_server.h"

namespace motiondb::tests {

inline constexpr char kReflection[] =
    "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo";

// A message with one field.
inline std::string WithString(int field, const std::string& value) {
  google::protobuf::UnknownFieldSet message;
  message.AddLengthDelimited(field, value);
  std::string bytes;
  message.SerializeToString(&bytes);
  return bytes;
}

// Returns the values of a length-delimited field of a message.
inline std::vector<std::string> Values(const std::string& message, int number) {
  google::protobuf::UnknownFieldSet fields;
  REQUIRE(fields.ParseFromString(message));
  std::vector<std::string> values;
  for (int i = 0; i < fields.field_count(); ++i) {
    const auto& field = fields.field(i);
    if (field.number() == number) values.push_back(field.length_delimited());
  }
  return values;
}

inline std::vector<std::string> ListServices(TestServer& server) {
  constexpr int kListServices = 7;          // of ServerReflectionRequest
  constexpr int kListServicesResponse = 6;  // of ServerReflectionResponse
  const RawAnswer answer = RawCall(server.channel(), kReflection, WithString(kListServices, "*"));
  REQUIRE(answer.status.ok());
  const auto responses = Values(answer.bytes, kListServicesResponse);
  REQUIRE(responses.size() == 1);
  std::vector<std::string> names;
  for (const std::string& service : Values(responses[0], 1)) {
    names.push_back(Values(service, 1).at(0));
  }
  return names;
}

// Returns the services of motiondb.
inline std::vector<std::string> ListOwnServices(TestServer& server) {
  std::vector<std::string> names = ListServices(server);
  std::erase_if(names, [](const std::string& name) { return !name.starts_with("motiondb."); });
  REQUIRE(names.size() == 13);
  return names;
}

// grpc.health.v1.HealthCheckResponse, of which `status` is field 1.
inline const std::string kServing = "\x08\x01";
inline const std::string kNotServing = "\x08\x02";

// Health of a service, or of the whole server if the name is empty.
inline RawAnswer CheckHealth(TestServer& server, const std::string& service = "") {
  return RawCall(server.channel(), "/grpc.health.v1.Health/Check",
                 service.empty() ? "" : WithString(1, service));
}

}  // namespace motiondb::tests
