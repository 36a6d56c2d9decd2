#include "tests/simulation/clients.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "server/engine/work/operation_wait.h"
#include "tests/simulation/motions.h"

namespace motiondb::simulation {
namespace {

using server::Pool;
using storage::OperationRecord;

constexpr std::array kClips = {"a", "b", "c", "d"};
constexpr std::array kDatabases = {"d0", "d1"};

template <std::size_t count>
std::string AnyOf(const std::array<const char*, count>& names) {
  return names[World::Current().Below(count)];
}

Duration Latency() { return World::Current().Between(microseconds(100), milliseconds(3)); }

// The first part of an id; the second one is random.
std::string Short(const std::string& operation) { return operation.substr(0, operation.find('-')); }
std::string Code(const absl::Status& status) { return absl::StatusCodeToString(status.code()); }

}  // namespace

Clients::Clients(Cluster& cluster, History& history) : cluster_(cluster), history_(history) {
  history_.set_on_model([this](const DatabaseLife& life) {
    AskAtNextLook(life);
    if (max_model_delay_ > Duration()) AskAfterDelay(life);
  });
}

template <typename Result>
absl::StatusOr<Result> Clients::Call(int server, Pool pool, Work<Result> work) {
  struct Answer {
    absl::StatusOr<Result> result = absl::DeadlineExceededError("no answer");
    bool has_come = false;
    WaitList waiting;
  };
  World& world = World::Current();
  const Time deadline = world.now() + world.Between(seconds(1), seconds(12));
  world.Sleep(Latency());
  server::Engine* const engine = cluster_.engine(server);
  if (engine == nullptr) return absl::UnavailableError("no server answers");
  const auto answer = std::make_shared<Answer>();
  if (!world.Chance(world.hazards.lost_message)) {
    Process* const process = cluster_.process(server);
    engine->workers().Post(pool, [=, &world, work = std::move(work)] {
      const core::Cancelled cancelled = [&world, deadline] { return world.now() > deadline; };
      auto result = work({*engine, cancelled});
      if (process->is_dead || world.Chance(world.hazards.lost_message)) return;
      world.At(world.now() + Latency(), nullptr, [answer, result = std::move(result)] {
        answer->result = result;
        answer->has_come = true;
        answer->waiting.WakeAll();
      });
    });
  }
  while (!answer->has_come && answer->waiting.WaitUntil(deadline)) {
  }
  return answer->result;
}

template <typename Result>
absl::StatusOr<Result> Clients::Change(int server, const std::string& database, Work<Result> work) {
  return Call<Result>(
      server, Pool::kChanges,
      [this, database, work = std::move(work)](const Request& request) -> absl::StatusOr<Result> {
        const Time begin = World::Current().now();
        auto result = work(request);
        DatabaseLife* const life = history_.Find(database);
        if (life == nullptr) return result;
        if (result.ok() && life->incomplete && *life->incomplete < begin) life->incomplete.reset();
        return result;
      });
}

int Clients::AnyServer() const {
  return static_cast<int>(World::Current().Below(static_cast<std::uint64_t>(cluster_.size())));
}

template <typename Function>
auto Clients::Find(const std::string& database, const Function& find) {
  const DatabaseLife* const before = history_.Find(database);
  const std::int64_t life = before == nullptr ? 0 : before->id;
  auto found = find();
  const DatabaseLife* const after = history_.Find(database);
  if (absl::IsNotFound(storage::StatusOf(found)) && after != nullptr && after->id == life) {
    World::Current().Fail(fmt::format("a server does not find database {}", database));
  }
  return found;
}

absl::StatusOr<std::shared_ptr<server::LiveDatabase>> Clients::FindDatabase(
    server::Engine& engine, const std::string& database) {
  return Find(database, [&] { return engine.FindDatabase(database); });
}

void Clients::Start(int client) {
  ++running_;
  World::Current().Start(nullptr, [this, client] {
    while (!is_stopping_) {
      World& world = World::Current();
      world.Sleep(world.Chance(0.3) ? world.Between({}, milliseconds(20))
                                    : world.Between({}, milliseconds(1500)));
      Step(client);
    }
    --running_;
  });
}

void Clients::Step(int client) {
  World& world = World::Current();
  const std::string database = world.Chance(0.7) ? kDatabases[0] : kDatabases[1];
  const std::string clip = AnyOf(kClips);
  const auto choice = world.Below(100);
  const char* what = "";
  absl::Status done;
  const auto run = [&](const char* name, absl::Status result) {
    what = name;
    done = std::move(result);
  };
  if (choice < 2) {
    run("delete database", Delete(database));
  } else if (choice < 30) {
    run("ingest", Ingest(database, static_cast<int>(world.Below(kMotions)), clip));
  } else if (choice < 42) {
    run("delete clip", DeleteClip(database, clip));
  } else if (choice < 54) {
    run("set label", SetLabel(database, clip));
  } else if (choice < 58) {
    run("reprocess", Reprocess(database));
  } else if (choice < 66) {
    run("list", List(database));
  } else if (choice < 78) {
    run("ask for model", AskForModel(database));
  } else if (choice < 82) {
    run("cancel", Cancel());
  } else if (choice < 88) {
    run("get operation", GetOperation());
  } else if (choice < 94) {
    run("wait", WaitForOperation());
  } else if (choice < 96) {
    run("create token", MakeToken());
  } else if (choice < 97) {
    run("revoke token", RevokeToken(AnyServer()));
  } else {
    run("use token", UseAnyToken());
  }
  world.Trace(fmt::format("client {}: {} {} {}: {}", client, what, database, clip, Code(done)));
  if (absl::IsNotFound(done) && history_.Find(database) == nullptr) {
    done = Create(database);
    world.Trace(fmt::format("client {}: create {}: {}", client, database, Code(done)));
  }
}

absl::Status Clients::Create(const std::string& database) {
  return Call<bool>(AnyServer(), Pool::kChanges,
                    [database](const Request& request) -> absl::StatusOr<bool> {
                      const core::BuildSettings settings{.frame_rate_hz = 60, .min_frames = 4};
                      const auto created = request.engine.CreateDatabase(
                          database, settings, {server::kSourceMarkerSet, ""},
                          {nullptr, request.cancelled});
                      if (!created.ok()) return created.status();
                      return true;
                    })
      .status();
}

absl::Status Clients::Delete(const std::string& database) {
  return Call<bool>(
             AnyServer(), Pool::kChanges,
             [this, database](const Request& request) -> absl::StatusOr<bool> {
               const absl::Status deleted = Find(database, [&] {
                 return request.engine.DeleteDatabase(database, {nullptr, request.cancelled});
               });
               if (!deleted.ok()) return deleted;
               return true;
             })
      .status();
}

absl::Status Clients::Ingest(const std::string& database, int motion, const std::string& clip) {
  const auto ingested = Change<server::Ingested>(
      AnyServer(), database,
      [this, database, motion, clip](const Request& request) -> absl::StatusOr<server::Ingested> {
        const auto live = FindDatabase(request.engine, database);
        if (!live.ok()) return live.status();
        const auto in_flight = request.engine.BeginIngest(*live);
        if (!in_flight.ok()) return in_flight.status();
        server::IngestRequest ingest;
        ingest.clip.record.id = clip;
        ingest.clip.record.file_name = clip + ".bvh";
        ingest.clip.id_is_fixed = true;
        ingest.clip.file_bytes = Motion(motion);
        ingest.replace = motion % 4 == 0;
        server::WorkOptions terms;
        terms.cancelled = request.cancelled;
        return request.engine.Ingest(*live, std::move(ingest), terms);
      });
  if (!ingested.ok()) return ingested.status();
  if (history_.FindByClip(database, ingested->clip.create_time_us) == nullptr) {
    World::Current().Fail(fmt::format("clip {} was acknowledged and not stored", clip));
  }
  NoteOperation(ingested->operation);
  return absl::OkStatus();
}

absl::Status Clients::DeleteClip(const std::string& database, const std::string& clip) {
  const auto deleted = Change<OperationRecord>(
      AnyServer(), database,
      [this, database, clip](const Request& request) -> absl::StatusOr<OperationRecord> {
        if (auto live = FindDatabase(request.engine, database); !live.ok()) return live.status();
        return request.engine.DeleteClip(database, clip, {nullptr, request.cancelled});
      });
  if (!deleted.ok()) return deleted.status();
  NoteOperation(*deleted);
  return absl::OkStatus();
}

absl::Status Clients::SetLabel(const std::string& database, const std::string& clip) {
  storage::ClipChange change{.clip = clip};
  change.label = fmt::format("label{}", ++label_count_);
  const auto edited = Change<server::Edited>(
      AnyServer(), database,
      [this, database, change](const Request& request) -> absl::StatusOr<server::Edited> {
        if (auto live = FindDatabase(request.engine, database); !live.ok()) return live.status();
        return request.engine.Edit(database, std::vector<storage::Change>{change}, "somebody",
                                   {nullptr, request.cancelled});
      });
  if (!edited.ok()) return edited.status();
  if (edited->operation) NoteOperation(*edited->operation);
  return absl::OkStatus();
}

absl::Status Clients::Reprocess(const std::string& database) {
  const auto requested = Change<OperationRecord>(
      AnyServer(), database,
      [this, database](const Request& request) -> absl::StatusOr<OperationRecord> {
        if (auto live = FindDatabase(request.engine, database); !live.ok()) return live.status();
        return request.engine.ReprocessDatabase(database, request.cancelled);
      });
  if (!requested.ok()) return requested.status();
  NoteOperation(*requested);
  return absl::OkStatus();
}

absl::Status Clients::List(const std::string& database) {
  const int server = AnyServer();
  return Call<bool>(
             server, Pool::kRequests,
             [this, database, server](const Request& request) -> absl::StatusOr<bool> {
               const DatabaseLife* const life = history_.Find(database);
               const std::int64_t revision = life == nullptr ? 0 : life->contents.back().revision;
               const auto live = FindDatabase(request.engine, database);
               if (!live.ok()) return live.status();
               const auto catalog = (*live)->Catalog(request.engine.store().annotations());
               if (!catalog.ok()) return catalog.status();
               const bool is_known = life != nullptr && !life->is_deleted &&
                                     cluster_.LifeOf(server, live->get()) == life->id;
               if (!is_known) return true;
               if ((*catalog)->revision() < revision) {
                 World::Current().Fail(fmt::format("a list of {} is of revision {}, not {}",
                                                   database, (*catalog)->revision(), revision));
               }
               std::map<std::string, std::string> labels;
               (*catalog)->ForEach([&](const server::CatalogClip& clip) {
                 labels[clip.id] = clip.segments.empty() ? "" : clip.segments.front().label;
                 return true;
               });
               history_.CheckListed("list of " + database, *life, (*catalog)->revision(), labels);
               return true;
             })
      .status();
}

absl::Status Clients::Cancel() {
  const std::string id = AnyOperation();
  if (id.empty()) return absl::OkStatus();
  const auto cancelled =
      Call<server::Cancellation>(AnyServer(), Pool::kChanges, [id](const Request& request) {
        return request.engine.CancelOperation(id, request.cancelled);
      });
  if (!cancelled.ok()) return cancelled.status();
  NoteOperation(cancelled->operation);
  return absl::OkStatus();
}

absl::Status Clients::GetOperation() {
  const std::string id = AnyOperation();
  if (id.empty()) return absl::OkStatus();
  const auto found = Call<OperationRecord>(
      AnyServer(), Pool::kRequests,
      [id](const Request& request) { return request.engine.operations().Get(id); });
  if (found.ok()) {
    NoteOperation(*found);
    return absl::OkStatus();
  }
  const auto life = history_.lives().find(operations_.at(id).life);
  if (absl::IsNotFound(found.status()) && life != history_.lives().end() &&
      !life->second.is_deleted) {
    World::Current().Fail(fmt::format("operation {} is not found", Short(id)));
  }
  return absl::OkStatus();
}

absl::Status Clients::WaitForOperation() {
  const std::string id = AnyOperation();
  const int server = AnyServer();
  server::Engine* const engine = cluster_.engine(server);
  const Process* const process = cluster_.process(server);
  if (id.empty() || engine == nullptr) return absl::OkStatus();
  struct Answer {
    absl::StatusOr<OperationRecord> record = absl::DeadlineExceededError("no answer");
    bool has_come = false;
    WaitList waiting;
  };
  World& world = World::Current();
  const auto answer = std::make_shared<Answer>();
  const Duration timeout = world.Between({}, seconds(8));
  engine->workers().Post(Pool::kRequests, [=] {
    server::OperationWait::Start(engine->workers(), engine->operations(), id, timeout,
                                 [answer, process](absl::StatusOr<OperationRecord> record) {
                                   if (process->is_dead) return;
                                   answer->record = std::move(record);
                                   answer->has_come = true;
                                   answer->waiting.WakeAll();
                                 });
  });
  const Time end = world.now() + seconds(20);
  while (!answer->has_come && answer->waiting.WaitUntil(end)) {
  }
  if (answer->record.ok()) NoteOperation(*answer->record);  // otherwise the server may be dead
  return absl::OkStatus();
}

void Clients::NoteOperation(const OperationRecord& operation) {
  KnownOperation& known = operations_[operation.id];
  known.life = history_.LifeOfOperation(operation.id);
  const auto of = history_.lives().find(known.life);
  if (of != history_.lives().end() && of->second.is_deleted) return;  // it ends with its database
  // A server that runs a cancelled operation shows it as running until it stops.
  if (known.result && operation.done() && *known.result != operation.state) {
    World::Current().Fail(fmt::format("operation {} had ended with {}, and is now {}",
                                      Short(operation.id), static_cast<int>(*known.result),
                                      static_cast<int>(operation.state)));
  }
  if (operation.done()) known.result = operation.state;
  // ABORTED: clips were deleted during each attempt.
  if (operation.state == storage::OperationState::kFailed &&
      operation.error_code != static_cast<int>(absl::StatusCode::kAborted)) {
    World::Current().Fail(
        fmt::format("operation {} failed: {}", Short(operation.id), operation.error_message));
  }
}

std::string Clients::AnyOperation() const {
  if (operations_.empty()) return "";
  // One of the newest.
  const auto back = World::Current().Below(std::min<std::uint64_t>(operations_.size(), 4));
  return std::prev(operations_.end(), static_cast<std::ptrdiff_t>(back) + 1)->first;
}

void Clients::AddLastClip(const std::string& database) {
  ++running_;
  World::Current().Start(nullptr, [this, database] {
    for (int attempt = 0; attempt < 100; ++attempt) {
      const absl::Status done = Ingest(database, attempt % kMotions, "last");
      if (done.ok() || absl::IsNotFound(done)) break;
      World::Current().Sleep(milliseconds(100));
    }
    --running_;
  });
}

void Clients::CheckOperations() {
  for (const auto& [id, known] : operations_) {
    const auto life = history_.lives().find(known.life);
    if (life == history_.lives().end() || life->second.is_deleted) continue;
    const auto stored = history_.store().GetOperation(id);
    if (!stored.ok()) {
      World::Current().Fail(
          fmt::format("operation {} is lost: {}", Short(id), Code(stored.status())));
    }
    NoteOperation(*stored);
  }
}

}  // namespace motiondb::simulation
