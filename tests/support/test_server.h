// A server in the process of the test, on a loopback socket, over a real store in a temporary file;
// and frequent calls.
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
  // With other options. Use a short rebuild delay.
  explicit TestServer(const server::ServerOptions& options);
  ~TestServer();

  // Stops the server and starts a new one on the same file.
  void Restart();
  void Stop();
  void Start();

  server::Server& server() { return *server_; }
  // Used by the next Start.
  server::ServerOptions& options() { return options_; }
  // `gate` blocks reads of clips by a build, `model_gate` the write of its model.
  Gate& gate() { return *gate_; }
  Gate& model_gate() { return *model_gate_; }
  SimulatedDisk& disk() { return *disk_; }
  const std::shared_ptr<grpc::Channel>& channel() { return channel_; }
  // Returns a new channel with its own connection.
  std::shared_ptr<grpc::Channel> NewChannel() const;
  // The same, for a client that reads slowly or nothing: its flow-control window stays at 64 KiB.
  std::shared_ptr<grpc::Channel> NewSmallChannel() const;

  // Example: NewStub<v1::ClipService>().
  template <typename Service>
  std::unique_ptr<typename Service::Stub> NewStub() {
    return Service::NewStub(channel_);
  }

  // Creates a database on the markers of its first clip, with small nodes: quick to build.
  void CreateDatabase(const std::string& id);
  // Streams a file in small blocks.
  grpc::Status Ingest(const v1::IngestClipHeader& header, const std::string& bytes,
                      v1::IngestClipResponse* response = nullptr);
  // Ingests a figure as NAME.bvh with a label. REQUIREs success.
  v1::IngestClipResponse IngestFigure(const std::string& database, const std::string& name,
                                      const std::string& label, const StickFigure& figure);
  // Waits at most 1 minute until the operation is done.
  v1::Operation Wait(const std::string& operation);
  // Creates a database `id` with a walk, a squat, a wave, and their model, version 1.
  void CreateTrained(const std::string& id);
  v1::DatabaseStatistics Describe(const std::string& id);

 private:
  server::ServerOptions options_;
  TemporaryDirectory directory_;
  const std::shared_ptr<Gate> gate_ = std::make_shared<Gate>();
  const std::shared_ptr<Gate> model_gate_ = std::make_shared<Gate>();
  const std::shared_ptr<SimulatedDisk> disk_ = std::make_shared<SimulatedDisk>();
  std::unique_ptr<server::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

// Returns a walk as a file observation.
v1::Observation WalkObservation();

// Result of a unary call.
template <typename Response>
struct Answer {
  grpc::Status status;
  Response response;
};

// Makes a unary call, with a token if one is given: Ask(*stub, &Stub::GetClip, request).
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

// Returns the fields in the details of an error, joined by commas.
std::string ViolatedFields(const grpc::Status& status);

}  // namespace motiondb::tests
