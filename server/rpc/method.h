// Which call of the contract a request belongs to. Safe to use from any thread.
#pragma once

#include <google/protobuf/descriptor.h>

#include <string>
#include <vector>

#include "server/security/role_table.h"

namespace motiondb::server {

struct Method {
  std::string name;                // "DatabaseService.GetDatabase"
  const CallRule* rule = nullptr;  // null: the table has none, and the call is refused
  bool streaming = false;          // on either side
  CallWeight weight = CallWeight::kLight;
};

// The method of the role table whose input is this type: every call has a request type of its own.
Method FindMethod(const google::protobuf::Descriptor& request_type);

// The same, looked up once.
template <typename Request>
const Method& MethodOf() {
  static const Method method = FindMethod(*Request::descriptor());
  return method;
}

// The names of all calls of the contract.
std::vector<std::string> MethodNames();

}  // namespace motiondb::server
