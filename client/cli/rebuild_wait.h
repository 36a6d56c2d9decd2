// Waiting for the model that a change of the clips asked for, and what the model is then.
#pragma once

#include <motiondb/client.h>

#include <string>

namespace motiondb::client {

// Waits for the operation with a progress bar. The operation as it ended, or the error that it or
// the call ended with. `done_before`, such as "2 clips are stored", follows the error: that stays
// so without the model.
absl::StatusOr<v1::Operation> WaitForRebuild(const Client& client, const std::string& operation,
                                             const std::string& done_before);

// ", 3 of them added since it was built (0.4 % of frames in nodes that a build would divide)";
// empty where none was.
std::string AddedSinceText(int added_clips, double drift_fraction);

// "model 3: 19 clips, 6552 frames, built in 4.21 s", or that no clip is left for a model.
absl::StatusOr<std::string> ModelSummary(const Client& client, const v1::Operation& operation);

}  // namespace motiondb::client
