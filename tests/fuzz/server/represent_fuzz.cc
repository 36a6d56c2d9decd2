// Represent requests, from bytes to the answer.
#include "core/motion/error.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/translate/observation_message.h"
#include "tests/fuzz/server/answer_properties.h"
#include "tests/fuzz/server/message_mutation.h"
#include "tests/fuzz/server/trained_engine.h"
#include "tests/fuzz/support/motion_properties.h"

using namespace motiondb;

MOTIONDB_MUTATE_AS(v1::RepresentRequest)

namespace {

absl::Status Represent(const v1::RepresentRequest& request, v1::RepresentResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto observation,
                            server::ParseObservation("observation", request.observation(), "db"));
  MOTIONDB_ASSIGN_OR_RETURN(const auto markers, tests::Trained().Ask().Markers(observation));
  tests::CheckMotion(markers);
  server::SetMarkers(markers, *response.mutable_markers());
  return absl::OkStatus();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  v1::RepresentRequest request;
  if (!request.ParseFromArray(data, static_cast<int>(size))) return 0;
  v1::RepresentResponse response;
  tests::CheckRefusalContract(Represent(request, response));
  tests::CheckAllFinite(response);
  return 0;
}
