// The other servers of a shared store. Each one announces its address in the store, so that the
// others can forward the calls that concern its streams. Thread-safe.
#pragma once

#include <grpcpp/security/credentials.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "server/engine/work/executor.h"
#include "server/security/security_options.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"

namespace motiondb::server {

class FileReloader;

class OtherServers {
 public:
  using Stub = std::shared_ptr<v1::ObserveService::StubInterface>;

  // `name`: of this server, unique. Store and executor must outlive it.
  OtherServers(storage::MotionStore& store, const Executor& executor, std::string name);
  ~OtherServers();

  const std::string& name() const { return name_; }

  // From now on the others reach this server at `address` (empty: they do not). Calls to them are
  // protected as those of this server's clients, with its own certificate; its files are read again
  // every second. INVALID_ARGUMENT with the path of an invalid file. Called once.
  absl::Status Begin(std::string address, const SecurityOptions& security);
  // Announces this server, at most every few seconds. Called every second, by one thread at a time.
  void Announce();

  // NOT_FOUND if there is no such server; UNAVAILABLE if the store does not answer.
  absl::StatusOr<Stub> Find(const std::string& server);
  // Those that have announced themselves in the last seconds. Some may have stopped.
  absl::StatusOr<std::vector<Stub>> All();

 private:
  struct Known {
    std::string name;
    std::string address;
    Stub stub;
  };
  // Brings `known_` up to date with the store.
  absl::StatusOr<std::vector<Known>> Look();
  // Reads the files. Returns whether they are new; then later calls use them.
  absl::StatusOr<bool> TakeCertificates();

  storage::MotionStore& store_;
  const Executor& executor_;
  const std::string name_;
  SecurityOptions security_;  // constant after Begin
  // In use. Of Begin, then of the thread of watch_.
  TlsContents own_;
  std::string authorities_;
  Executor::Clock::time_point next_announcement_;

  storage::Mutex mutex_;
  std::string address_ ABSL_GUARDED_BY(mutex_);
  // Null before Begin. security_ is not read before.
  std::shared_ptr<grpc::ChannelCredentials> credentials_ ABSL_GUARDED_BY(mutex_);
  std::vector<Known> known_ ABSL_GUARDED_BY(mutex_);  // keeps their connections
  std::unique_ptr<FileReloader> watch_;  // last member: its thread uses the members above
};

}  // namespace motiondb::server
