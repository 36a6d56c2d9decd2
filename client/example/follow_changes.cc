// Follows the clips and segments of a database, also across restarts of the server:
//   follow_changes HOST:PORT DATABASE
#include <motiondb/client.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/segment.pb.h>

#include <iostream>
#include <string>

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: follow_changes HOST:PORT DATABASE\n";
    return 2;
  }
  motiondb::client::ClientOptions options;
  options.server = argv[1];
  const auto client = motiondb::client::Client::Connect(options);
  if (!client.ok()) return std::cerr << client.status().message() << "\n", 1;

  motiondb::v1::WatchDatabaseRequest request;
  request.set_name(std::string("databases/") + argv[2]);
  motiondb::client::Watch watch = client->WatchDatabase(request);
  motiondb::v1::WatchDatabaseResponse change;
  while (watch.Next(change)) {
    if (change.has_clip()) {
      std::cout << change.clip().name() << ": " << change.clip().label() << std::endl;
    } else if (change.has_segment()) {
      std::cout << change.segment().name() << ": " << change.segment().label() << std::endl;
    } else if (!change.deleted().empty()) {
      std::cout << change.deleted() << ": deleted" << std::endl;
    }
  }
  std::cerr << watch.Finish().message() << "\n";
  return 1;
}
