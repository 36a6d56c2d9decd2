// ListStreams and WatchStream: the running Observe streams for others than their clients.
#pragma once

#include "motiondb/v1/observe.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/stream_reactor.h"

namespace motiondb::server {

// Handlers, as Answer and StreamReactor call them.

absl::Status ListStreams(const Call& call, const v1::ListStreamsRequest& request,
                         v1::ListStreamsResponse& response);

// The source makes the description of the stream, then each time the newest answer. It ends with
// the stream: UNAVAILABLE if the server stops; NOT_FOUND if the database is deleted.
absl::StatusOr<MessageSource<v1::WatchStreamResponse>> OpenWatchedStream(
    const Call& call, const v1::WatchStreamRequest& request);

}  // namespace motiondb::server
