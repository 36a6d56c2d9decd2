#include "client/cli/rebuild_wait.h"

#include <fmt/format.h>
#include <motiondb/v1/model.pb.h>
#include <motiondb/v1/operation.pb.h>

#include "client/call_failure.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"

namespace motiondb::client {

absl::StatusOr<v1::Operation> WaitForRebuild(const Client& client, const std::string& operation,
                                             const std::string& done_before) {
  const auto with_done_before = [&](const absl::Status& status, const std::string& message) {
    const bool is_unavailable = absl::IsUnavailable(status);
    return WithMessage(
        status,
        fmt::format(
            "{}; {}{}", message, done_before,
            is_unavailable ? ", and the server builds the model after its next start" : ""));
  };
  ProgressBar bar;
  auto done = client.WaitOperation(operation, [&](const v1::Operation& now) {
    bar.Show(now.progress(), "model: " + (now.stage().empty() ? "waiting" : now.stage()));
  });
  if (!done.ok()) {
    return with_done_before(done.status(), std::string(done.status().message()));
  }
  if (const absl::Status status = OperationStatus(*done); !status.ok()) {
    return with_done_before(
        status, fmt::format("the new model was not built: {}", std::string(status.message())));
  }
  return done;
}

std::string AddedClipsText(int added_clips, double drift_fraction) {
  if (added_clips == 0) return "";
  return fmt::format(
      ", {} of them added since the build ({:.1f} % of frames in nodes that a build would split)",
      added_clips, 100 * drift_fraction);
}

absl::StatusOr<std::string> ModelSummary(const Client& client, const v1::Operation& operation) {
  if (ModelOf(operation).empty()) return std::string("no clip is left, so there is no model now");
  v1::GetModelRequest request;
  request.set_name(ModelOf(operation));
  const auto response = client.GetModel(request);
  if (!response.ok()) return response.status();
  const v1::Model& model = response->model();
  return fmt::format("model {}: {}{}, {}, {}, built in {:.2f} s", model.version(),
                     CountText(model.clip_count(), "clip"),
                     AddedClipsText(model.added_clip_count(), model.drift_fraction()),
                     CountText(model.frame_count(), "frame"),
                     CountText(model.nodes_per_layer_size(), "layer"), model.build_seconds());
}

}  // namespace motiondb::client
