#include "server/rpc/other_servers.h"

#include <grpcpp/create_channel.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/motion/error.h"
#include "server/security/operator_files.h"
#include "server/security/tls.h"

namespace motiondb::server {
namespace {

using std::chrono::milliseconds;
using storage::MutexLock;

constexpr milliseconds kAnnouncePeriod{5000};
// Longer, so that a slow store does not hide a server.
constexpr milliseconds kAnnounced{15'000};

}  // namespace

OtherServers::OtherServers(storage::MotionStore& store, const Executor& executor, std::string name)
    : store_(store), executor_(executor), name_(std::move(name)) {}

OtherServers::~OtherServers() = default;

absl::Status OtherServers::Begin(std::string address, const SecurityOptions& security) {
  security_ = security;
  if (security.tls.enabled()) {
    MOTIONDB_RETURN_IF_ERROR(TakeCertificates().status());
    watch_ = std::make_unique<FileReloader>(
        "certificates for other servers",
        security.peer_ca.empty() ? security.tls.certificate : security.peer_ca,
        [this] { return TakeCertificates(); });
  }
  const MutexLock lock(mutex_);
  if (!security.tls.enabled()) credentials_ = grpc::InsecureChannelCredentials();
  address_ = std::move(address);
  return absl::OkStatus();
}

absl::StatusOr<bool> OtherServers::TakeCertificates() {
  MOTIONDB_ASSIGN_OR_RETURN(TlsContents own, ReadTlsFiles(security_.tls));
  std::string authorities;
  if (!security_.peer_ca.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(authorities, ReadTextFile(security_.peer_ca));
  }
  if (own == own_ && authorities == authorities_) return false;
  own_ = std::move(own);
  authorities_ = std::move(authorities);
  const MutexLock lock(mutex_);
  credentials_ = grpc::SslCredentials({.pem_root_certs = authorities_,
                                       .pem_private_key = own_.key,
                                       .pem_cert_chain = own_.certificate});
  known_.clear();  // a running call keeps its connection
  return true;
}

void OtherServers::Announce() {
  const auto now = executor_.Now();
  std::string address;
  {
    const MutexLock lock(mutex_);
    address = address_;
  }
  if (address.empty() || now < next_announcement_) return;
  if (const absl::Status put = store_.AnnounceServer({name_, address}, kAnnounced); !put.ok()) {
    spdlog::debug("this server was not announced: {}", std::string(put.message()));
    return;
  }
  next_announcement_ = now + kAnnouncePeriod;
}

absl::StatusOr<std::vector<OtherServers::Known>> OtherServers::Look() {
  MOTIONDB_ASSIGN_OR_RETURN(const auto servers, store_.ListServers());
  const MutexLock lock(mutex_);
  std::vector<Known> found;
  for (const storage::ServerAddress& server : servers) {
    if (server.name == name_ || credentials_ == nullptr) continue;
    const auto known = std::ranges::find(known_, server.name, &Known::name);
    if (known != known_.end() && known->address == server.address) {
      found.push_back(*known);
      continue;
    }
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(-1);  // responses have their own limits
    if (!security_.peer_name.empty()) arguments.SetSslTargetNameOverride(security_.peer_name);
    found.push_back({server.name, server.address,
                     v1::ObserveService::NewStub(
                         grpc::CreateCustomChannel(server.address, credentials_, arguments))});
  }
  known_ = found;
  return found;
}

absl::StatusOr<OtherServers::Stub> OtherServers::Find(const std::string& server) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto servers, Look());
  const auto found = std::ranges::find(servers, server, &Known::name);
  if (found != servers.end()) return found->stub;
  return core::NotFound("there is no server '{}'", server);
}

absl::StatusOr<std::vector<OtherServers::Stub>> OtherServers::All() {
  MOTIONDB_ASSIGN_OR_RETURN(const auto servers, Look());
  std::vector<Stub> stubs;
  stubs.reserve(servers.size());
  for (const Known& server : servers) stubs.push_back(server.stub);
  return stubs;
}

}  // namespace motiondb::server
