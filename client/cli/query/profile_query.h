// The generation probabilities of a motion at several layers, as a picture.
#pragma once

#include <motiondb/client.h>
#include <motiondb/messages.h>

#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/plot/canvas.h"

namespace motiondb::client {

// Asks for all clips by the paper's method at each layer, and returns the picture. No layers: the
// bottom layer, a middle and an upper one. Ignores method, layer and number of clips of `request`.
absl::StatusOr<Canvas> AskForProfile(const Client& client, v1::RecognizeRequest request,
                                     const std::vector<int>& layers);

}  // namespace motiondb::client
