// Recognize requests, from bytes to the answer.
#include "core/motion/error.h"
#include "core/recognition/recognize.h"
#include "motiondb/v1/query.pb.h"
#include "server/translate/observation_message.h"
#include "server/translate/query_message.h"
#include "tests/fuzz/server/answer_properties.h"
#include "tests/fuzz/server/message_mutation.h"
#include "tests/fuzz/server/query_deadline.h"
#include "tests/fuzz/server/trained_engine.h"

using namespace motiondb;

MOTIONDB_MUTATE_AS(v1::RecognizeRequest)

namespace {

absl::Status Recognize(const v1::RecognizeRequest& request, v1::RecognizeResponse& response) {
  const server::Query query = tests::Trained().Ask(tests::AfterSeconds(tests::kQuerySeconds));
  MOTIONDB_ASSIGN_OR_RETURN(const auto options, server::ParseRecognizeOptions(request));
  MOTIONDB_ASSIGN_OR_RETURN(const auto observation,
                            server::ParseObservation("observation", request.observation(), "db"));
  MOTIONDB_ASSIGN_OR_RETURN(const auto answer,
                            query.Recognize(observation, options, request.top_count()));
  server::SetRecognition(answer, "db", query.model(), request.top_count(), response);
  return absl::OkStatus();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  v1::RecognizeRequest request;
  if (!request.ParseFromArray(data, static_cast<int>(size))) return 0;
  v1::RecognizeResponse response;
  tests::CheckRefusalOrCancelled(Recognize(request, response));
  tests::CheckAllFinite(response);
  return 0;
}
