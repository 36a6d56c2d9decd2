// Reads the geometry of pictures from the server.
#pragma once

#include <motiondb/client.h>

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/picture/map_picture.h"

namespace motiondb::client {

// Reads a layer of the current model. `layer` 0: the bottom layer; `clip`: full name, or empty for
// the global graph; `points`: maximum number of frames.
absl::StatusOr<StateMap> ReadMap(const Client& client, const std::string& database, int layer,
                                 const std::string& clip, int points);

// Returns the bones of the markers of a database. `database`: short or full name.
absl::StatusOr<Bones> ReadBones(const Client& client, const std::string& database);

// Returns the mean poses of nodes, given by their ids.
absl::StatusOr<std::vector<MeanPose>> ReadMeanPoses(const Client& client,
                                                    const std::string& database, int layer,
                                                    const std::vector<int>& node_ids);

// Returns poses of a clip at moments spread evenly over it. `clip`: full name.
absl::StatusOr<std::vector<ClipMoment>> ReadMoments(const Client& client, const std::string& clip,
                                                    int count);

}  // namespace motiondb::client
