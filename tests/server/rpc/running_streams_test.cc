#include "server/rpc/running_streams.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <thread>

#include "server/engine/model_lifecycle.h"

namespace motiondb::server::running_streams_test {
namespace {

using Spectator = RunningStream::Spectator;

std::shared_ptr<LiveDatabase> Database(const std::string& name) {
  return std::make_shared<LiveDatabase>(name, core::BuildSettings());
}

// As an Observe stream does: counts an answer and, if somebody watches, publishes it.
bool AnswerFrame(RunningStream& stream, std::int64_t frame) {
  const auto number = stream.CountAnswer(frame);
  if (!number) return false;
  v1::WatchStreamResponse answer;
  answer.mutable_answer()->set_frame(frame);
  stream.Publish(*number, std::move(answer));
  return true;
}

TEST_CASE("RunningStreams: lists the streams of a database, oldest first", "[server][streams]") {
  RunningStreams streams;
  const auto walks = Database("walks");
  const auto other = Database("other");
  const auto first = streams.Add(walks, {});
  const auto second = streams.Add(other, {});
  auto third = streams.Add(walks, {});
  CHECK(first->stream().Description().name() == "databases/walks/streams/1");
  CHECK(second->stream().Description().name() == "databases/other/streams/2");
  REQUIRE(streams.List(*walks, 10).size() == 2);
  CHECK(streams.List(*walks, 10)[1]->Description().name() == "databases/walks/streams/3");
  CHECK(streams.List(*walks, 1).size() == 1);
  CHECK(streams.Find(*walks, "3").ok());
  third.reset();
  CHECK(streams.List(*walks, 10).size() == 1);
  CHECK(streams.List(*Database("walks"), 10).empty());  // created again
  for (const char* const id : {"3", "2", "0", "", "x", "1x", "-1", "99999999999999999999"}) {
    INFO(id);
    CHECK(absl::IsNotFound(streams.Find(*walks, id).status()));
  }
  CHECK(streams.Add(walks, {})->stream().Description().name() == "databases/walks/streams/4");
}

TEST_CASE("RunningStream: a spectator gets the newest answer and how many it missed",
          "[server][streams]") {
  const auto stream = std::make_shared<RunningStream>(Database("walks"), v1::ObservedStream());
  CHECK_FALSE(AnswerFrame(*stream, 1));  // no spectator
  Spectator one(stream);
  CHECK_FALSE(one.Take().has_value());
  CHECK(AnswerFrame(*stream, 2));
  Spectator late(stream);
  CHECK_FALSE(late.Take().has_value());  // from the next answer on
  auto answer = one.Take();
  REQUIRE(answer.has_value());
  CHECK(answer->answer().frame() == 2);
  CHECK(answer->skipped_count() == 0);
  CHECK_FALSE(one.Take().has_value());
  for (int frame = 3; frame <= 6; ++frame) CHECK(AnswerFrame(*stream, frame));
  for (Spectator* const spectator : {&one, &late}) {
    answer = spectator->Take();
    REQUIRE(answer.has_value());
    CHECK(answer->answer().frame() == 6);
    CHECK(answer->skipped_count() == 3);
  }
  CHECK(stream->Description().frame() == 6);
  CHECK_FALSE(stream->ended().has_value());
  AnswerFrame(*stream, 7);
  stream->End(absl::OkStatus());
  CHECK(stream->ended().has_value());
  CHECK(one.Take().value().answer().frame() == 7);  // the last answer is not lost
}

TEST_CASE("RunningStream: without spectators it keeps no answer", "[server][streams]") {
  const auto stream = std::make_shared<RunningStream>(Database("walks"), v1::ObservedStream());
  std::optional<std::int64_t> number;
  {
    const Spectator gone(stream);
    number = stream->CountAnswer(1);
  }
  REQUIRE(number.has_value());
  stream->Publish(*number, {});  // it left meanwhile
  CHECK_FALSE(stream->CountAnswer(2).has_value());
  Spectator next(stream);
  CHECK_FALSE(next.Take().has_value());
}

// Taken and skipped answers together are all answers, in order, whatever the threads do.
TEST_CASE("RunningStream: concurrent spectators miss no number", "[server][streams]") {
  constexpr std::int64_t kAnswers = 20'000;
  const auto stream = std::make_shared<RunningStream>(Database("walks"), v1::ObservedStream());
  std::atomic<int> ready = 0;
  std::atomic<int> wrong = 0;
  const auto watch = [&] {
    Spectator spectator(stream);
    std::int64_t last = 0;
    ++ready;
    while (last < kAnswers) {
      const auto answer = spectator.Take();
      if (!answer) continue;
      const std::int64_t frame = answer->answer().frame();
      if (frame != last + answer->skipped_count() + 1) ++wrong;
      last = frame;
    }
  };
  std::thread first(watch);
  std::thread second(watch);
  while (ready < 2) std::this_thread::yield();
  for (std::int64_t frame = 1; frame <= kAnswers; ++frame) AnswerFrame(*stream, frame);
  first.join();
  second.join();
  CHECK(wrong == 0);
}

}  // namespace
}  // namespace motiondb::server::running_streams_test
