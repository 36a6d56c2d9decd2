// The details of errors, and the error of a call above a limit.
#pragma once

#include <grpcpp/support/status.h>

#include <catch2/catch.hpp>
#include <string>

#include "motiondb/v1/error.pb.h"
#include "server/translate/status_mapping.h"

namespace motiondb::tests {

// Returns the detail of an error with this type URL. REQUIREs exactly one.
template <typename Message>
Message DetailOf(const grpc::Status& error, const std::string& type_url) {
  v1::Status details;
  REQUIRE(details.ParseFromString(error.error_details()));
  Message found;
  int count = 0;
  for (const auto& detail : details.details()) {
    if (detail.type_url() != type_url) continue;
    REQUIRE(found.ParseFromString(detail.value()));
    ++count;
  }
  INFO(type_url);
  REQUIRE(count == 1);
  return found;
}

// Returns the reason of an error.
inline std::string ReasonOf(const grpc::Status& error) {
  return DetailOf<v1::ErrorInfo>(error, "type.googleapis.com/google.rpc.ErrorInfo").reason();
}

// Expects RESOURCE_EXHAUSTED with the setting ("--max-calls"), the retry time and the request id.
inline void CheckRefusal(const grpc::Status& error, const std::string& setting) {
  INFO(error.error_message());
  REQUIRE(error.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
  CHECK(error.error_message().find("(" + setting + ")") != std::string::npos);
  const auto retry = DetailOf<v1::RetryInfo>(error, server::kRetryInfoUrl).retry_delay();
  CHECK(static_cast<double>(retry.seconds()) + 1e-9 * retry.nanos() > 0);
  CHECK(!DetailOf<v1::RequestInfo>(error, server::kRequestInfoUrl).request_id().empty());
}

}  // namespace motiondb::tests
