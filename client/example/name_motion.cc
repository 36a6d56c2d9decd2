// What is this motion? Names each window of a file: name_motion DATABASE FILE.bvh
#include <motiondb/client.h>
#include <motiondb/v1/query.pb.h>

#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto client = motiondb::client::Client::Connect({.server = "127.0.0.1:50051"});
  if (!client.ok()) return std::cerr << client.status().message() << "\n", 1;

  std::stringstream bytes;
  bytes << std::ifstream(argv[2], std::ios::binary).rdbuf();
  motiondb::v1::RecognizeRequest request;
  request.set_database(std::string("databases/") + argv[1]);
  request.mutable_observation()->mutable_file()->set_file_name(argv[2]);
  request.mutable_observation()->mutable_file()->set_data(bytes.str());

  const auto answer = client->Recognize(request);
  if (!answer.ok()) return std::cerr << answer.status().message() << "\n", 1;
  for (const auto& window : answer->windows()) {
    if (window.labels().empty()) continue;
    std::cout << window.start_seconds() << " s: " << window.labels(0).label() << "\n";
  }
}
