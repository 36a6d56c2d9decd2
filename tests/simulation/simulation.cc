#include "tests/simulation/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tests/simulation/clients.h"
#include "tests/simulation/cluster.h"
#include "tests/simulation/history.h"
#include "tests/simulation/world.h"

namespace motiondb::simulation {
namespace {

constexpr seconds kAccidentTime{20};
// From the last accident until all servers have the newest model with all clips: a lease of a
// killed builder (5 s), the polls of another server (4 s), the longest delay of a build (option),
// the build and the load.
constexpr seconds kRecoveryTime{20};
// Until the content of a deleted database is freed, by the server that deleted it or another one.
constexpr seconds kMaxPurgeDelay{660};
// From the storing of a model until it is part of all answers, with its notification and without.
constexpr milliseconds kMaxNoticeDelay{1000};
constexpr milliseconds kMaxLookDelay{2500};

class Simulation {
 public:
  Simulation(std::uint64_t seed, Protection removed)
      : world_(seed), store_(removed), history_(store_) {}

  std::uint64_t Run() {
    SetHazards();
    Cluster cluster(store_, history_, Options());
    Clients clients(cluster, history_);
    world_.after_event = [&](Process* process) {
      if (process != nullptr) cluster.CheckServed(process);
    };
    for (int client = 0; client < 3; ++client) clients.Start(client);
    const Time end = world_.now() + kAccidentTime;
    while (world_.now() < end) {
      world_.RunUntil(world_.now() + world_.Between(milliseconds(10), milliseconds(1500)));
      Accident(cluster);
    }
    clients.Stop();
    world_.hazards = {};
    cluster.Heal();
    world_.RunUntil(world_.now() + kRecoveryTime);
    if (!clients.all_have_ended()) world_.Fail("a client does not end");
    CheckRecovered(cluster, /*is_complete=*/false);
    world_.hazards.lost_notice = world_.Chance(0.5) ? 1 : 0;
    clients.set_max_model_delay(world_.hazards.lost_notice > 0 ? kMaxLookDelay : kMaxNoticeDelay);
    for (const auto& [id, life] : history_.lives()) {
      if (!life.is_deleted) clients.AddLastClip(life.name);
    }
    world_.RunUntil(world_.now() + kRecoveryTime);
    if (!clients.all_have_ended()) world_.Fail("the last clips are not acknowledged");
    CheckRecovered(cluster, /*is_complete=*/true);
    clients.CheckOperations();
    AskForModels(cluster, clients);
    clients.RevokeLastToken();
    world_.RunUntil(world_.now() + kRecoveryTime);
    if (!clients.all_have_ended()) world_.Fail("a call with a token does not end");
    // In few seeds, since servers look at the store each second.
    if (world_.Chance(0.01)) {
      world_.RunUntil(world_.now() + kMaxPurgeDelay);
      history_.CheckIsFreed();
    }
    Stop(cluster);
    return world_.trace_hash();
  }

 private:
  double Sometimes(double probability, double rate) {
    return world_.Chance(probability) ? rate : 0;
  }

  void SetHazards() {
    // Against an extension of which the builder does not learn, while it builds for long, only the
    // compare-and-set protects.
    const double lost_extension = Sometimes(0.3, 0.8);
    world_.hazards = {.preemption = Sometimes(0.7, 0.02),
                      .long_work = Sometimes(0.6, 0.1) + (lost_extension > 0 ? 0.2 : 0),
                      .slow_call = Sometimes(0.5, 0.01),
                      .refused_call = Sometimes(0.4, 0.01) + Sometimes(0.2, 0.08),
                      .lost_answer = Sometimes(0.4, 0.02) + Sometimes(0.3, 0.08),
                      .lost_extension = lost_extension,
                      .lost_message = Sometimes(0.5, 0.05),
                      .lost_notice = Sometimes(0.3, 1) + Sometimes(0.3, 0.3)};
    accident_ = Sometimes(0.8, 0.7);
  }

  std::vector<server::EngineOptions> Options() {
    server::EngineOptions options;
    options.rebuild_delay_limit = milliseconds(3000);
    const bool always_extends = world_.hazards.lost_extension > 0 || world_.Chance(0.5);
    const double extend_from = always_extends ? 0 : world_.Chance(0.5) ? 0.01 : 3600;
    options.extend_from = std::chrono::duration<double>(extend_from);
    std::vector<server::EngineOptions> all(2 + world_.Below(2), options);
    if (world_.Chance(0.2)) {
      all.back().work =
          world_.Chance(0.7) ? server::ServerWork::kServe : server::ServerWork::kBuild;
    }
    if (world_.Chance(0.4)) {
      for (server::EngineOptions& each : all) each.model_memory_bytes = ModelMemory();
    }
    return all;
  }

  // Most models have 30 to 100 kB.
  std::int64_t ModelMemory() {
    constexpr std::array<std::int64_t, 5> kSizes = {0, 1, 60'000, 120'000, 1'000'000'000};
    return kSizes[world_.Below(kSizes.size())];
  }

  void Accident(Cluster& cluster) {
    if (!world_.Chance(accident_)) return;
    const auto server = static_cast<int>(world_.Below(static_cast<std::uint64_t>(cluster.size())));
    Process& process = *cluster.process(server);
    switch (world_.Below(10)) {
      case 0:
      case 1:
        return cluster.Crash(server, world_.Between(milliseconds(100), seconds(4)));
      case 2:
        return cluster.Drain(server, world_.Between(milliseconds(100), seconds(4)));
      case 3:
      case 4:
      case 5:
        process.paused_until = world_.now() + world_.Between({}, seconds(9));
        return world_.Trace(fmt::format("pause {}", server));
      case 6:
      case 7:
        process.cut_off_until = world_.now() + world_.Between({}, seconds(9));
        return world_.Trace(fmt::format("cut off {}", server));
      case 8:
        for (int other = 0; other < cluster.size(); ++other) {
          cluster.process(other)->cut_off_until = world_.now() + seconds(4);
        }
        return world_.Trace("cut off all");
      default:
        return;
    }
  }

  // Checks the state after all accidents. `is_complete`: each database was changed after them.
  void CheckRecovered(Cluster& cluster, bool is_complete) {
    if (!cluster.all_are_up()) world_.Fail("a server has not started");
    if (const auto unfinished = *history_.store().ListUnfinishedOperations(); !unfinished.empty()) {
      const std::string& id = unfinished.front().id;
      world_.Fail(fmt::format("operation {} does not end", id.substr(0, id.find('-'))));
    }
    std::size_t count = 0;
    for (const auto& [id, life] : history_.lives()) {
      if (life.is_deleted) continue;
      ++count;
      for (int server = 0; server < cluster.size(); ++server) {
        CheckDatabase(cluster, server, life, is_complete || !life.incomplete);
      }
    }
    for (int server = 0; server < cluster.size(); ++server) {
      if (cluster.engine(server)->Databases().size() != count) {
        world_.Fail(fmt::format("server {} has a deleted database", server));
      }
      CheckMemory(cluster, server);
      if (!cluster.engine(server)->corruptions().empty()) {
        world_.Fail(fmt::format("server {} has found corruption", server));
      }
    }
  }

  void CheckDatabase(const Cluster& cluster, int server, const DatabaseLife& life,
                     bool is_complete) {
    const std::string what = fmt::format("in the end server {}, database {}", server, life.name);
    std::shared_ptr<server::LiveDatabase> live;
    for (const auto& each : cluster.engine(server)->Databases()) {
      if (each->name() == life.name) live = each;
    }
    if (live == nullptr) world_.Fail(what + ": is not served");
    if (cluster.LifeOf(server, live.get()) != life.id) world_.Fail(what + ": is a deleted one");
    const server::ServedModel served = live->lifecycle().served();
    const int version = served.record() == nullptr ? 0 : served.record()->version;
    // After a cancelled build, a server may serve its model, which is not stored.
    const bool is_stored = served.snapshot == nullptr || served.snapshot->is_stored();
    if (version != life.current_model || (is_complete && !is_stored)) {
      world_.Fail(fmt::format("{}: serves model {} and not {}", what, version, life.current_model));
    }
    if (!is_complete) return;
    const std::int64_t revision = life.contents.back().revision;
    if (served.snapshot != nullptr && served.revision < revision) {
      world_.Fail(fmt::format("{}: the model is of revision {}, and not {}", what, served.revision,
                              revision));
    }
    const auto clips = served.record() == nullptr ? 0 : served.record()->clip_count;
    if (clips != std::ssize(life.clips())) {
      world_.Fail(
          fmt::format("{}: the model has {} of {} clips", what, clips, life.clips().size()));
    }
  }

  // Checks that each server returns all models, and keeps its limit of memory then.
  void AskForModels(Cluster& cluster, Clients& clients) {
    for (int server = 0; server < cluster.size(); ++server) {
      for (const auto& [id, life] : history_.lives()) {
        if (life.is_deleted || life.clips().empty()) continue;
        for (int call = 0; call < 3; ++call) clients.AskForLastModel(server, life);
      }
    }
    world_.RunUntil(world_.now() + seconds(10));
    if (!clients.all_have_ended()) world_.Fail("a call for a model does not end");
    CheckRecovered(cluster, /*is_complete=*/true);
  }

  // The last used model stays, and models that are not stored.
  void CheckMemory(const Cluster& cluster, int server) {
    const std::int64_t limit = cluster.engine(server)->options().model_memory_bytes;
    std::int64_t bytes = 0;
    int count = 0;
    for (const auto& live : cluster.engine(server)->Databases()) {
      const auto snapshot = live->lifecycle().snapshot();
      if (snapshot == nullptr || !snapshot->is_stored()) continue;
      bytes += live->lifecycle().model_bytes();
      ++count;
    }
    if (limit > 0 && bytes > limit && count > 1) {
      world_.Fail(fmt::format("server {} has {} models of {} bytes, the limit is {} bytes", server,
                              count, bytes, limit));
    }
  }

  void Stop(Cluster& cluster) {
    cluster.Stop();
    world_.RunUntil(world_.now() + seconds(5));
    if (!cluster.all_are_down()) world_.Fail("a server does not end");
    world_.RunUntil(world_.now() + seconds(15));
    if (world_.task_count() > 0) world_.Fail("a thread does not end");
  }

  World world_;
  StoreServer store_;
  History history_;
  double accident_ = 0;
};

}  // namespace

std::uint64_t Simulate(std::uint64_t seed, Protection removed) {
  return Simulation(seed, removed).Run();
}

}  // namespace motiondb::simulation
