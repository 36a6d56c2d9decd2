#include "tests/bench/served_motion.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "client/cli/motion_file.h"
#include "core/motion/error.h"
#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/motion_source.h"
#include "tests/support/real_data.h"

namespace motiondb::tests {
namespace {
namespace fs = std::filesystem;

std::string Name(const std::string& database) { return "databases/" + database; }

}  // namespace

absl::StatusOr<std::vector<MotionBytes>> ReadClips(const std::string& list) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto listed, ReadClipList(DataDir() / "sets" / (list + ".tsv")));
  std::vector<MotionBytes> clips;
  for (const ListedClip& row : listed) {
    MotionBytes& clip = clips.emplace_back();
    clip.header.set_file_name(row.path.filename().string());
    clip.header.set_label(row.label);
    MOTIONDB_ASSIGN_OR_RETURN(clip.file, ReadBytes(row.path));
    MOTIONDB_ASSIGN_OR_RETURN(const fs::path skeleton, client::SkeletonFor(row.path, {}));
    if (skeleton.empty()) continue;
    clip.header.set_skeleton_file_name(skeleton.filename().string());
    MOTIONDB_ASSIGN_OR_RETURN(clip.skeleton, ReadBytes(skeleton));
  }
  return clips;
}

absl::StatusOr<std::unique_ptr<ServedMotion>> ServedMotion::Start() {
  std::unique_ptr<ServedMotion> served(new ServedMotion);
  MOTIONDB_ASSIGN_OR_RETURN(auto store, storage::SqliteMotionStore::Open(served->File("store.db")));
  MOTIONDB_RETURN_IF_ERROR(served->Serve(std::move(store)));
  return served;
}

absl::StatusOr<std::unique_ptr<ServedMotion>> ServedMotion::StartWith(
    std::unique_ptr<storage::MotionStore> store) {
  std::unique_ptr<ServedMotion> served(new ServedMotion);
  MOTIONDB_RETURN_IF_ERROR(served->Serve(std::move(store)));
  return served;
}

absl::Status ServedMotion::Serve(std::unique_ptr<storage::MotionStore> store) {
  server::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.web_listen = "127.0.0.1:0";
  MOTIONDB_ASSIGN_OR_RETURN(server_, server::Server::Start(std::move(store), options));
  MOTIONDB_ASSIGN_OR_RETURN(auto client, client::Client::Connect({.server = address()}));
  client_ = std::move(client);
  return absl::OkStatus();
}

absl::Status ServedMotion::Create(const std::string& database) {
  v1::CreateDatabaseRequest request;
  request.set_database_id(database);
  return client_->CreateDatabase(request).status();
}

absl::StatusOr<v1::IngestClipResponse> ServedMotion::Ingest(const std::string& database,
                                                            const MotionBytes& clip) {
  v1::IngestClipHeader header = clip.header;
  header.set_parent(Name(database));
  return client_->IngestBytes(header, clip.file, clip.skeleton);
}

absl::Status ServedMotion::Fill(const std::string& database,
                                const std::vector<MotionBytes>& clips) {
  v1::IngestClipResponse last;
  for (const MotionBytes& clip : clips) {
    MOTIONDB_ASSIGN_OR_RETURN(last, Ingest(database, clip));
  }
  return Await(last.operation().name());
}

absl::Status ServedMotion::Await(const std::string& operation) {
  MOTIONDB_ASSIGN_OR_RETURN(const v1::Operation done, client_->WaitOperation(operation));
  return client::OperationStatus(done);
}

absl::StatusOr<int> ServedMotion::ModelVersion(const std::string& database) {
  v1::GetDatabaseRequest request;
  request.set_name(Name(database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto described, client_->GetDatabase(request));
  return described.database().model_version();
}

absl::StatusOr<v1::MarkerObservation> ServedMotion::Represent(const std::string& database,
                                                              const MotionBytes& clip,
                                                              int frame_rate_hz) {
  v1::RepresentRequest request;
  request.set_database(Name(database));
  v1::FileObservation& file = *request.mutable_observation()->mutable_file();
  file.set_file_name(clip.header.file_name());
  file.set_data(clip.file);
  file.set_skeleton_file_name(clip.header.skeleton_file_name());
  file.set_skeleton_data(clip.skeleton);
  MOTIONDB_ASSIGN_OR_RETURN(const auto represented, client_->Represent(request));
  const v1::MarkerObservation& all = represented.markers();
  const auto step = static_cast<int>(std::lround(all.frame_rate_hz() / frame_rate_hz));
  if (step < 1 || std::abs(all.frame_rate_hz() - step * frame_rate_hz) > 1e-3 * frame_rate_hz) {
    return core::InvalidArgument("{}: frame rate is {} Hz; expected a multiple of {} Hz",
                                 clip.header.file_name(), all.frame_rate_hz(), frame_rate_hz);
  }
  v1::MarkerObservation markers;
  markers.set_frame_rate_hz(frame_rate_hz);
  if (all.has_leg_length_m()) markers.set_leg_length_m(all.leg_length_m());
  for (int f = 0; f < all.frame_count(); f += step) {
    markers.mutable_positions()->append(Cut(all, f, 1).positions());
    markers.set_frame_count(markers.frame_count() + 1);
  }
  return markers;
}

v1::MarkerObservation Cut(const v1::MarkerObservation& markers, int first, int count) {
  const std::size_t width = markers.positions().size() / markers.frame_count();
  v1::MarkerObservation cut;
  cut.set_frame_rate_hz(markers.frame_rate_hz());
  if (markers.has_leg_length_m()) cut.set_leg_length_m(markers.leg_length_m());
  cut.set_frame_count(count);
  cut.set_positions(markers.positions().substr(first * width, count * width));
  return cut;
}

}  // namespace motiondb::tests
