// Plan requests, from bytes to the answer. Steps limit the search instead of time, so that every
// input is reproducible.
#include "core/motion/error.h"
#include "core/planning/plan.h"
#include "motiondb/v1/plan.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/translate/plan_message.h"
#include "tests/fuzz/server/answer_properties.h"
#include "tests/fuzz/server/message_mutation.h"
#include "tests/fuzz/server/query_deadline.h"
#include "tests/fuzz/server/trained_engine.h"

using namespace motiondb;

MOTIONDB_MUTATE_AS(v1::PlanRequest)

namespace {

constexpr int kSearchSteps = 30;
constexpr int kWorkSteps = 2000;  // then cancelled, e.g. inverse kinematics of long motions

absl::Status Plan(const v1::PlanRequest& request, v1::PlanResponse& response) {
  const server::Query query = tests::Trained().Ask();
  MOTIONDB_ASSIGN_OR_RETURN(const auto plan, server::ParsePlanRequest(request, "db"));
  MOTIONDB_ASSIGN_OR_RETURN(server::PreparedPlan prepared, server::PreparePlan(query, plan));
  int search_steps = 0;
  int work_steps = 0;
  const core::Cancelled cancelled = [&] { return ++work_steps > kWorkSteps; };
  const core::PlanControl control{.cancelled = cancelled,
                                  .time_up = [&] { return ++search_steps > kSearchSteps; }};
  server::PlanResult result{.body = prepared.body};
  MOTIONDB_ASSIGN_OR_RETURN(result.answer, core::PlanMotion(query.model(), prepared.body.scheme,
                                                            prepared.problem, control));
  if (plan.with_files) {
    MOTIONDB_ASSIGN_OR_RETURN(result.files, server::WriteMotions(result.answer, result.body,
                                                                 plan.file_format, cancelled));
  }
  server::SetPlan(std::move(result), "db", query.model(), response);
  return absl::OkStatus();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  v1::PlanRequest request;
  if (!request.ParseFromArray(data, static_cast<int>(size))) return 0;
  v1::PlanResponse response;
  tests::CheckRefusalOrCancelled(Plan(request, response));
  tests::CheckAllFinite(response);
  return 0;
}
