#include "tests/bench/empty_peer.h"

#include <fmt/format.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <utility>

namespace motiondb::tests {
namespace {

// One call: a message in, the reply out. A stream repeats this until the client half-closes.
class Call final : public grpc::ServerGenericBidiReactor {
 public:
  Call(EmptyPeer::Shape shape, const grpc::ByteBuffer& reply) : shape_(shape), reply_(reply) {
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::OK);
    if (shape_ == EmptyPeer::Shape::kUnary) {
      StartWriteAndFinish(&reply_, grpc::WriteOptions(), grpc::Status::OK);
    } else {
      StartWrite(&reply_);
    }
  }
  void OnWriteDone(bool ok) override {
    if (shape_ == EmptyPeer::Shape::kUnary) return;  // finished by StartWriteAndFinish
    if (!ok) return Finish(grpc::Status::CANCELLED);
    StartRead(&request_);
  }
  void OnDone() override { delete this; }

 private:
  const EmptyPeer::Shape shape_;
  const grpc::ByteBuffer reply_;  // shares the bytes
  grpc::ByteBuffer request_;
};

class Unknown final : public grpc::ServerGenericBidiReactor {
 public:
  Unknown() { Finish({grpc::StatusCode::UNIMPLEMENTED, "unknown method of the empty peer"}); }
  void OnDone() override { delete this; }
};

}  // namespace

class EmptyPeer::Service final : public grpc::CallbackGenericService {
 public:
  explicit Service(std::map<std::string, Method> methods) {
    for (const auto& [name, method] : methods) {
      const grpc::Slice bytes(method.reply);
      replies_[name] = {method.shape, grpc::ByteBuffer(&bytes, 1)};
    }
  }

  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* context) override {
    const auto found = replies_.find(context->method());
    if (found == replies_.end()) return new Unknown;
    return new Call(found->second.shape, found->second.bytes);
  }

 private:
  struct Reply {
    Shape shape = Shape::kUnary;
    grpc::ByteBuffer bytes;
  };
  std::map<std::string, Reply> replies_;
};

EmptyPeer::EmptyPeer() = default;

EmptyPeer::~EmptyPeer() {
  if (grpc_ != nullptr) grpc_->Shutdown();
}

absl::StatusOr<std::unique_ptr<EmptyPeer>> EmptyPeer::Start(std::map<std::string, Method> methods) {
  std::unique_ptr<EmptyPeer> peer(new EmptyPeer);
  peer->service_ = std::make_unique<Service>(std::move(methods));
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterCallbackGenericService(peer->service_.get());
  peer->grpc_ = builder.BuildAndStart();
  if (peer->grpc_ == nullptr || port == 0) {
    return absl::UnavailableError("the empty peer cannot listen on 127.0.0.1");
  }
  peer->address_ = fmt::format("127.0.0.1:{}", port);
  return peer;
}

}  // namespace motiondb::tests
