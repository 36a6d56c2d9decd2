// Stores a motion file in a database, then recognizes another one:
//   recognize_motion HOST:PORT DATABASE LABEL KNOWN.bvh UNKNOWN.bvh
#include <motiondb/client.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/operation.pb.h>
#include <motiondb/v1/query.pb.h>

#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

namespace {

using motiondb::client::Client;
namespace v1 = motiondb::v1;

// Stores the file and waits for the model with it.
absl::Status Ingest(const Client& client, const std::string& database, const std::string& label,
                    const std::string& file) {
  v1::IngestClipHeader header;
  header.set_parent(database);
  header.set_label(label);
  const auto stored = client.IngestFile(header, file);
  if (!stored.ok()) return stored.status();
  std::cout << "stored " << stored->clip().name() << ", " << stored->clip().frame_count()
            << " frames\n";
  const auto done = client.WaitOperation(stored->operation().name());
  return done.ok() ? motiondb::client::OperationStatus(*done) : done.status();
}

// Prints the most probable label of each window.
absl::Status Recognize(const Client& client, const std::string& database, const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  v1::RecognizeRequest request;
  request.set_database(database);
  request.mutable_observation()->mutable_file()->set_file_name(file);
  request.mutable_observation()->mutable_file()->set_data(
      std::string(std::istreambuf_iterator<char>(in), {}));
  const auto answer = client.Recognize(request);
  if (!answer.ok()) return answer.status();
  for (const auto& window : answer->windows()) {
    if (window.labels().empty()) continue;
    std::cout << window.start_seconds() << " s: " << window.labels(0).label() << ", probability "
              << window.labels(0).probability() << "\n";
  }
  return absl::OkStatus();
}

absl::Status Run(const std::string& server, const std::string& database, const std::string& label,
                 const std::string& known, const std::string& unknown) {
  motiondb::client::ClientOptions options;
  options.server = server;
  const auto client = Client::Connect(options);
  if (!client.ok()) return client.status();
  const absl::Status status = Ingest(*client, database, label, known);
  return status.ok() ? Recognize(*client, database, unknown) : status;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) {
    std::cerr << "usage: recognize_motion HOST:PORT DATABASE LABEL KNOWN.bvh UNKNOWN.bvh\n";
    return 2;
  }
  const std::string database = std::string("databases/") + argv[2];
  const absl::Status status = Run(argv[1], database, argv[3], argv[4], argv[5]);
  if (status.ok()) return 0;
  std::cerr << status.message() << "\n";
  return 1;
}
