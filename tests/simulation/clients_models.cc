// Calls of the clients that need a model.
#include <fmt/format.h>

#include "tests/simulation/clients.h"
#include "tests/simulation/model_call.h"

namespace motiondb::simulation {

absl::Status Clients::AskForModel(const std::string& database) {
  World& world = World::Current();
  const auto call = std::make_shared<ModelCall>(cluster_, history_, AnyServer(), database);
  // Without a revision it waits only until the model is read, so it ends without a deadline.
  if (world.Chance(0.5)) return call->Send(0, Time::max()).status();
  const DatabaseLife* const life = history_.Find(database);
  const std::int64_t revision = life == nullptr ? 0 : life->contents.back().revision;
  return call->Send(revision, world.now() + world.Between(seconds(1), seconds(12))).status();
}

void Clients::AskAtNextLook(const DatabaseLife& life) {
  World& world = World::Current();
  for (int server = 0; server < cluster_.size(); ++server) {
    ++running_;
    const auto ask = [this, server, database = life.name] {
      const auto call = std::make_shared<ModelCall>(cluster_, history_, server, database);
      call->Send(0, Time::max()).IgnoreError();
      --running_;
    };
    // A server looks 50 ms after a notification.
    world.Start(nullptr, ask, world.Between(milliseconds(45), milliseconds(100)));
  }
}

void Clients::AskAfterDelay(const DatabaseLife& life) {
  const int version = life.models.rbegin()->first;
  for (int server = 0; server < cluster_.size(); ++server) {
    ++running_;
    const auto ask = [this, server, version, database = life.name] {
      const auto call = std::make_shared<ModelCall>(cluster_, history_, server, database);
      const auto served = call->Send(0, Time::max());
      if (!served.ok() || served->snapshot->record.version < version) {
        World::Current().Fail(
            fmt::format("server {} has no answer with model {} of {} in time: {}", server, version,
                        database, served.ok() ? "it is older" : served.status().ToString()));
      }
      --running_;
    };
    World::Current().Start(nullptr, ask, max_model_delay_);
  }
}

void Clients::AskForLastModel(int server, const DatabaseLife& life) {
  ++running_;
  const auto ask = [this, server, &life] {
    World& world = World::Current();
    const auto call = std::make_shared<ModelCall>(cluster_, history_, server, life.name);
    const auto served = call->Send(life.contents.back().revision, world.now() + seconds(5));
    if (!served.ok()) {
      world.Fail(fmt::format("in the end server {} does not return the model of {}: {}", server,
                             life.name, served.status().ToString()));
    }
    --running_;
  };
  World::Current().Start(nullptr, ask, World::Current().Between({}, seconds(2)));
}

}  // namespace motiondb::simulation
