// Calls of ListStreams and WatchStream that concern streams of other servers of a shared store.
#pragma once

#include <vector>

#include "motiondb/v1/observe.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/other_servers.h"
#include "server/rpc/stream_reactor.h"

namespace motiondb::server {

// Returns the streams that the other servers run. A server that does not answer within a second is
// left out. Blocks as long.
std::vector<v1::ObservedStream> StreamsOfOthers(const Call& call, OtherServers& others,
                                                const v1::ListStreamsRequest& request);

// Returns the messages of WatchStream of another server. It ends as the call there does;
// UNAVAILABLE if that server stops or cannot be reached.
MessageSource<v1::WatchStreamResponse> ForwardWatch(const Call& call,
                                                    const OtherServers::Stub& owner,
                                                    const v1::WatchStreamRequest& request);

}  // namespace motiondb::server
