// Waits for the model after a change of clips, and describes it.
#pragma once

#include <motiondb/client.h>

#include <string>

namespace motiondb::client {

// Waits for the operation with a progress bar. Returns the ended operation, or the error of the
// operation or call. Appends `done_before`, such as "2 clips are stored", to the error: it remains
// valid without the model.
absl::StatusOr<v1::Operation> WaitForRebuild(const Client& client, const std::string& operation,
                                             const std::string& done_before);

// Returns ", 3 of them added since the build (0.4 % of frames in nodes that a build would split)",
// or an empty string if none was added.
std::string AddedClipsText(int added_clips, double drift_fraction);

// Returns "model 3: 19 clips, 6552 frames, 20 layers, built in 4.21 s", or that there is no model.
absl::StatusOr<std::string> ModelSummary(const Client& client, const v1::Operation& operation);

}  // namespace motiondb::client
