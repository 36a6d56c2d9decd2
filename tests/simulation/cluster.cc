#include "tests/simulation/cluster.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace motiondb::simulation {

Cluster::Cluster(StoreServer& store, History& history, std::vector<server::EngineOptions> options)
    : store_(store), history_(history) {
  for (server::EngineOptions& each : options) servers_.push_back({.options = each});
  for (Server& server : servers_) Start(server);
}

server::Engine* Cluster::engine(int server) const {
  const Server& of = servers_[server];
  return of.is_ending || of.process->is_dead ? nullptr : of.engine.get();
}

server::TokenRegistry* Cluster::TokensOf(const server::Engine& engine) const {
  const auto of = std::ranges::find_if(
      servers_, [&](const Server& server) { return server.engine.get() == &engine; });
  return of == servers_.end() ? nullptr : of->tokens.get();
}

void Cluster::Start(Server& server) {
  World& world = World::Current();
  processes_.push_back(std::make_unique<Process>());
  server.process = processes_.back().get();
  server.process->name = fmt::format("{}.{}", &server - servers_.data(), processes_.size());
  server.process->clock_offset = world.Between(milliseconds(-1000), milliseconds(1000));
  server.is_ending = server.is_down = false;
  server.restart_delay = milliseconds(500);  // if it cannot start
  world.Start(server.process, [this, &server] { Run(server); });
}

void Cluster::Run(Server& server) {
  World& world = World::Current();
  auto opened = server::Engine::Open(std::make_unique<SimulatedStore>(store_, server.process),
                                     server.options);
  world.Trace(fmt::format("start: {}", absl::StatusCodeToString(opened.status().code())));
  if (opened.ok()) {
    auto tokens = std::make_unique<server::TokenRegistry>((*opened)->store().access());
    if (store_.removed() != Protection::kRevocation) {
      (*opened)->AddFollower([&tokens = *tokens] { tokens.FollowRevocations().IgnoreError(); });
    }
    server.tokens = std::move(tokens);
    server.engine = *std::move(opened);
  }
  if (server.engine == nullptr || server.is_ending || server.process->is_dead) End(server);
}

void Cluster::End(Server& server) {
  // Destroyed outside of the member, so that no fiber sees an engine that is being destroyed.
  const auto tokens = std::move(server.tokens);  // until the engine has ended
  auto engine = std::move(server.engine);
  engine.reset();
  server.served.clear();
  server.is_down = true;
  World& world = World::Current();
  world.Trace("end");
  world.At(world.now() + server.restart_delay, nullptr, [this, &server] {
    if (server.is_down && !is_stopping_) Start(server);
  });
}

void Cluster::Crash(int index, Duration restart_delay) {
  Server& server = servers_[index];
  if (server.is_down || server.process->is_dead) return;
  server.process->is_dead = true;
  World::Current().Trace(fmt::format("crash {}", index));
  Drain(index, restart_delay);
}

void Cluster::Drain(int index, Duration restart_delay) {
  Server& server = servers_[index];
  if (server.is_down || std::exchange(server.is_ending, true)) return;
  World& world = World::Current();
  world.Trace(fmt::format("drain {}", index));
  server.restart_delay = restart_delay;
  if (server.engine == nullptr) return;  // it ends when it has started
  world.Start(server.process, [this, &server] { End(server); });
}

void Cluster::Heal() {
  for (const auto& process : processes_) {
    process->paused_until = process->cut_off_until = World::Current().now();
  }
}

void Cluster::Stop() {
  is_stopping_ = true;
  for (int server = 0; server < size(); ++server) Drain(server, {});
}

bool Cluster::all_are_up() const {
  return std::ranges::all_of(
      servers_, [](const Server& server) { return server.engine != nullptr && !server.is_ending; });
}

bool Cluster::all_are_down() const { return std::ranges::all_of(servers_, &Server::is_down); }

std::int64_t Cluster::LifeOf(int server, const server::LiveDatabase* database) const {
  const auto seen = servers_[server].served.find(database);
  return seen == servers_[server].served.end() ? 0 : seen->second.life;
}

void Cluster::CheckServed(const Process* process) {
  for (Server& server : servers_) {
    if (server.process != process || server.engine == nullptr) continue;
    for (const auto& live : server.engine->Databases()) {
      const server::ServedModel served = live->lifecycle().served();
      Served& seen = server.served[live.get()];
      if (seen.database.lock() != live) {
        seen = {live, live->id(), nullptr, -1, 0};
      }
      const bool is_same = seen.record == served.record() && seen.revision == served.revision;
      if (is_same) continue;
      seen.record = served.record();
      seen.revision = served.revision;
      const std::string what = fmt::format("server {}, database {}", process->name, live->name());
      if (!history_.CheckServed(what, seen.life, served)) continue;
      if (served.record() != nullptr && (!served.snapshot || served.snapshot->is_stored())) {
        const int version = served.record()->version;
        if (version < std::exchange(seen.version, version)) {
          World::Current().Fail(fmt::format("{}: goes back to model {}", what, version));
        }
      }
    }
  }
}

}  // namespace motiondb::simulation
