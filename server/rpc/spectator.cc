#include "server/rpc/spectator.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/rpc/forwarded_stream.h"
#include "server/rpc/other_servers.h"
#include "server/rpc/running_streams.h"
#include "server/translate/page.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

// The answers of a stream for one spectator.
class SpectatorSource {
 public:
  // `call` must outlive it.
  SpectatorSource(const Call& call, std::shared_ptr<RunningStream> stream)
      : call_(call), spectator_(std::move(stream)) {}

  // AwaitsChange if there is no newer answer yet.
  absl::StatusOr<bool> Next(v1::WatchStreamResponse& message) {
    RunningStream& stream = spectator_.stream();
    if (!std::exchange(begun_, true)) {
      *message.mutable_stream() = stream.Description();
      return true;
    }
    call_.parking.WakeOn(*stream.signal());
    call_.parking.WakeOn(*stream.database()->signal());
    const auto ended = stream.ended();  // before the last answer is taken
    if (auto answer = spectator_.Take()) {
      message = *std::move(answer);
      return true;
    }
    // Also if the database was created again.
    const auto current = call_.engine.FindDatabase(stream.database()->name());
    if (!current.ok()) return current.status();
    if (*current != stream.database()) {
      return core::WithReason(
          "DATABASE_NOT_FOUND",
          core::NotFound("database '{}' was deleted and created again", stream.database()->name()));
    }
    if (!ended) return AwaitsChange();
    if (!ended->ok()) return *ended;
    return false;
  }

 private:
  const Call& call_;
  RunningStream::Spectator spectator_;
  bool begun_ = false;
};

}  // namespace

absl::Status ListStreams(const Call& call, const v1::ListStreamsRequest& request,
                         v1::ListStreamsResponse& response) {
  constexpr int kMaxStreams = 1000;
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto database, call.engine.FindDatabase(id));
  std::vector<v1::ObservedStream> streams;
  if (call.others != nullptr && !request.this_server()) {
    streams = StreamsOfOthers(call, *call.others, request);
  }
  for (const auto& stream : call.streams.List(*database, kMaxStreams)) {
    streams.push_back(stream->Description());
  }
  std::ranges::stable_sort(streams, [](const auto& a, const auto& b) {
    return std::pair(a.start_time().seconds(), a.start_time().nanos()) <
           std::pair(b.start_time().seconds(), b.start_time().nanos());
  });
  PageBudget budget(kMaxStreams);
  for (v1::ObservedStream& description : streams) {
    if (!budget.Take(description.ByteSizeLong())) break;
    *response.add_streams() = std::move(description);
  }
  return absl::OkStatus();
}

absl::StatusOr<MessageSource<v1::WatchStreamResponse>> OpenWatchedStream(
    const Call& call, const v1::WatchStreamRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseStreamName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto database, call.engine.FindDatabase(id.database));
  if (call.others != nullptr) {
    const auto owner = call.others->Find(id.id.substr(0, id.id.find('-')));
    if (owner.ok()) return ForwardWatch(call, *owner, request);
    if (!absl::IsNotFound(owner.status())) return owner.status();
  }
  MOTIONDB_ASSIGN_OR_RETURN(auto stream, call.streams.Find(*database, id.id));
  const auto source = std::make_shared<SpectatorSource>(call, std::move(stream));
  return [source](v1::WatchStreamResponse& message) { return source->Next(message); };
}

}  // namespace motiondb::server
