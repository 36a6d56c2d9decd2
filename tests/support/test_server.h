// A server in the test's own process, on a loopback socket, over a real store in a temporary file;
// and the calls that tests make most.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <memory>
#include <string>
#include <utility>

#include "server/server.h"
#include "tests/support/full_disk.h"
#include "tests/support/gated_store.h"
#include "tests/support/stick_figure.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::v1 {
class DatabaseStatistics;
class IngestClipHeader;
class IngestClipResponse;
class Observation;
class Operation;
}  // namespace motiondb::v1

namespace motiondb::tests {

// Whether an operation is in a final state.
bool IsDone(const v1::Operation& operation);

class TestServer {
 public:
  TestServer();
  // With settings of the test's own; a short rebuild delay is a good idea.
  explicit TestServer(const server::ServerOptions& options);
  ~TestServer();

  // Stops the server and starts another on the same file.
  void Restart();
  // Stops it, and starts it.
  void Stop();
  void Start();

  server::Server& server() { return *server_; }
  // What the next Start begins with.
  server::ServerOptions& options() { return options_; }
  // Where a build reads clips, and where it stores its model.
  Gate& gate() { return *gate_; }
  Gate& model_gate() { return *model_gate_; }
  FullDisk& disk() { return *disk_; }
  const std::shared_ptr<grpc::Channel>& channel() { return channel_; }
  // Another, with a connection of its own.
  std::shared_ptr<grpc::Channel> NewChannel() const;

  // NewStub<v1::ClipService>().
  template <typename Service>
  std::unique_ptr<typename Service::Stub> NewStub() {
    return Service::NewStub(channel_);
  }

  // A database on its first clip's own markers, with small nodes: quick to build.
  void CreateDatabase(const std::string& id);
  // Streams a file in small blocks.
  grpc::Status Ingest(const v1::IngestClipHeader& header, const std::string& bytes,
                      v1::IngestClipResponse* response = nullptr);
  // Ingests a figure as NAME.bvh under a label. REQUIREs success.
  v1::IngestClipResponse IngestFigure(const std::string& database, const std::string& name,
                                      const std::string& label, const StickFigure& figure);
  // Waits, a minute at most, until the operation is done.
  v1::Operation Wait(const std::string& operation);
  // A database `id` with a walk, a squat and a wave, and its model.
  void CreateTrained(const std::string& id);
  v1::DatabaseStatistics Describe(const std::string& id);

 private:
  server::ServerOptions options_;
  TemporaryDirectory directory_;
  const std::shared_ptr<Gate> gate_ = std::make_shared<Gate>();
  const std::shared_ptr<Gate> model_gate_ = std::make_shared<Gate>();
  const std::shared_ptr<FullDisk> disk_ = std::make_shared<FullDisk>();
  std::unique_ptr<server::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

// A walk as a file observation.
v1::Observation ObservedWalk();

// What a unary call came to.
template <typename Response>
struct Answer {
  grpc::Status status;
  Response response;
};

// Makes a unary call, as the bearer of a token if one is given: Ask(*stub, &Stub::GetClip,
// request).
template <typename Stub, typename Request, typename Response>
Answer<Response> Ask(Stub& stub,
                     grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                     const Request& request, const std::string& token = "") {
  grpc::ClientContext context;
  if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
  Answer<Response> answer;
  answer.status = (stub.*method)(&context, request, &answer.response);
  return answer;
}

// The fields that an error's details name, joined by commas.
std::string ViolatedFields(const grpc::Status& status);

}  // namespace motiondb::tests
