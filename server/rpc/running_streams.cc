#include "server/rpc/running_streams.h"

#include <charconv>
#include <string>
#include <utility>

#include "core/motion/error.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {

using storage::MutexLock;

v1::ObservedStream RunningStream::Description() const {
  v1::ObservedStream description = description_;
  const MutexLock lock(mutex_);
  description.set_frame(frame_);
  return description;
}

std::optional<std::int64_t> RunningStream::CountAnswer(std::int64_t frame) {
  const MutexLock lock(mutex_);
  frame_ = frame;
  ++answers_;
  return spectators_ > 0 ? std::optional(answers_) : std::nullopt;
}

void RunningStream::Publish(std::int64_t number, v1::WatchStreamResponse answer) {
  Published published{number, std::make_shared<const v1::WatchStreamResponse>(std::move(answer))};
  {
    const MutexLock lock(mutex_);
    if (spectators_ > 0) std::swap(newest_, published);
  }
  signal_->Notify();
}

void RunningStream::End(const absl::Status& why) {
  {
    const MutexLock lock(mutex_);
    ended_ = why;
  }
  signal_->Notify();
}

std::optional<absl::Status> RunningStream::ended() const {
  const MutexLock lock(mutex_);
  return ended_;
}

RunningStream::Spectator::Spectator(std::shared_ptr<RunningStream> stream)
    : stream_(std::move(stream)) {
  const MutexLock lock(stream_->mutex_);
  ++stream_->spectators_;
  taken_ = stream_->answers_;
}

RunningStream::Spectator::~Spectator() {
  const MutexLock lock(stream_->mutex_);
  if (--stream_->spectators_ == 0) stream_->newest_ = {};
}

std::optional<v1::WatchStreamResponse> RunningStream::Spectator::Take() {
  Published newest;
  {
    const MutexLock lock(stream_->mutex_);
    newest = stream_->newest_;
  }
  if (newest.number <= taken_) return std::nullopt;
  v1::WatchStreamResponse answer = *newest.answer;
  answer.set_skipped_count(newest.number - taken_ - 1);
  taken_ = newest.number;
  return answer;
}

std::unique_ptr<RunningStreams::Registration> RunningStreams::Add(
    std::shared_ptr<LiveDatabase> database, v1::ObservedStream description) {
  const MutexLock lock(mutex_);
  const std::uint64_t key = ++last_key_;
  description.set_name(StreamName(database->name(), prefix_ + std::to_string(key)));
  auto stream = std::make_shared<RunningStream>(std::move(database), std::move(description));
  streams_.emplace(key, stream);
  return std::make_unique<Registration>(*this, key, std::move(stream));
}

std::vector<std::shared_ptr<RunningStream>> RunningStreams::List(const LiveDatabase& database,
                                                                 int limit) const {
  std::vector<std::shared_ptr<RunningStream>> listed;
  const MutexLock lock(mutex_);
  for (const auto& [key, stream] : streams_) {
    if (std::ssize(listed) == limit) break;
    if (stream->database().get() == &database) listed.push_back(stream);
  }
  return listed;
}

absl::StatusOr<std::shared_ptr<RunningStream>> RunningStreams::Find(const LiveDatabase& database,
                                                                    const std::string& id) const {
  std::uint64_t key = 0;
  const char* const end = id.data() + id.size();
  const std::size_t begin = id.starts_with(prefix_) ? prefix_.size() : id.size();
  const auto [parsed, error] = std::from_chars(id.data() + begin, end, key);
  if (error == std::errc() && parsed == end) {
    const MutexLock lock(mutex_);
    const auto found = streams_.find(key);
    if (found != streams_.end() && found->second->database().get() == &database) {
      return found->second;
    }
  }
  return core::WithReason(
      "STREAM_NOT_FOUND",
      core::NotFound("database '{}' has no running stream '{}'; list them with ListStreams",
                     database.name(), id));
}

void RunningStreams::Remove(std::uint64_t key) {
  std::shared_ptr<RunningStream> removed;  // destroyed without the lock
  const MutexLock lock(mutex_);
  const auto found = streams_.find(key);
  removed = std::move(found->second);
  streams_.erase(found);
}

}  // namespace motiondb::server
