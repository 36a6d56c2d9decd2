#include "server/translate/query_message.h"

#include <catch2/catch.hpp>

#include "core/motion/error.h"
#include "motiondb/v1/query.pb.h"
#include "server/engine/query/query_memory.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::server::query_message_test {
namespace {

TEST_CASE("CheckScores: a response with too many clips and labels is refused",
          "[server][translate][hostile]") {
  const core::Model model = tests::SmallModel(2, 40, 3, 4, 1);
  core::RecognizedWindow window;
  window.clips.resize(1023);
  window.labels.resize(1);
  std::vector<core::RecognizedWindow> windows(1024, window);  // 2^20: the maximum
  windows.emplace_back().labels.resize(1);

  const absl::Status refused = CheckScores(windows, 0);
  CHECK(refused.code() == absl::StatusCode::kInvalidArgument);
  CHECK(refused.GetPayload(core::kFieldUrl).has_value());
  CHECK_THAT(std::string(refused.message()),
             Catch::StartsWith("top_count: the response would have 1048577 clips and labels in "
                               "1025 windows, the limit is 1048576"));
  CHECK(CheckScores(windows, 1023).code() == refused.code());

  // Fewer are accepted.
  REQUIRE(CheckScores(windows, 2).ok());
  v1::RecognizeResponse response;
  SetRecognition(windows, "d", model, 2, response);
  CHECK(response.windows_size() == 1025);
  CHECK(response.windows(0).clips_size() == 2);
}

}  // namespace
}  // namespace motiondb::server::query_message_test
