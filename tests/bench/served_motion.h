// A motiondb server in the benchmark's process with the recorded clips of database 1, and the
// requests of its clients. Not thread-safe, except through the client and the address.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "motiondb/client.h"
#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/observation.pb.h"
#include "server/server.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {

// A motion file in memory, ready for ingestion.
struct MotionBytes {
  v1::IngestClipHeader header;  // without its parent
  std::string file;
  std::string skeleton;  // empty if not needed

  std::size_t size() const { return file.size() + skeleton.size(); }
};

// Reads the clips of a list in the recorded data: "database1.train".
absl::StatusOr<std::vector<MotionBytes>> ReadClips(const std::string& list);

class ServedMotion {
 public:
  // Starts a server with default options, the HTTP API, and a store in a temporary directory.
  static absl::StatusOr<std::unique_ptr<ServedMotion>> Start();
  // The same, with this store.
  static absl::StatusOr<std::unique_ptr<ServedMotion>> StartWith(
      std::unique_ptr<storage::MotionStore> store);

  const std::string& address() const { return server_->address(); }
  // URL of the HTTP API.
  std::string web_address() const { return server_->web_address(); }
  // Returns the path of a file in the store's directory.
  std::string File(const std::string& name) const { return directory_ / name; }

  absl::Status Create(const std::string& database);
  // Returns when the clip is acknowledged.
  absl::StatusOr<v1::IngestClipResponse> Ingest(const std::string& database,
                                                const MotionBytes& clip);
  // Ingests clips and waits for the model that contains them.
  absl::Status Fill(const std::string& database, const std::vector<MotionBytes>& clips);
  // Waits until an operation has succeeded.
  absl::Status Await(const std::string& operation);
  // Returns the version of the current model.
  absl::StatusOr<int> ModelVersion(const std::string& database);
  // Returns a clip as frames of the database's markers at `frame_rate_hz`, a divisor of the clip's
  // rate. Markers have no names and are in the database's order.
  absl::StatusOr<v1::MarkerObservation> Represent(const std::string& database,
                                                  const MotionBytes& clip, int frame_rate_hz);

 private:
  ServedMotion() = default;
  absl::Status Serve(std::unique_ptr<storage::MotionStore> store);

  TemporaryDirectory directory_;
  std::unique_ptr<server::Server> server_;
  std::optional<client::Client> client_;
};

// Returns frames [first, first + count) of markers.
v1::MarkerObservation Cut(const v1::MarkerObservation& markers, int first, int count);

}  // namespace motiondb::tests
