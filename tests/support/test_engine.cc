#include "tests/support/test_engine.h"

#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>
#include <future>

#include "server/engine/snapshot.h"
#include "server/engine/work/operation_wait.h"
#include "storage/sqlite/sqlite_motion_store.h"

namespace motiondb::tests {

server::EngineOptions TestEngine::QuickOptions() {
  server::EngineOptions options;
  options.rebuild_delay = std::chrono::milliseconds(50);
  options.extend_from = std::chrono::hours(1);
  options.query_threads = 4;
  options.build_threads = 2;
  return options;
}

TestEngine::TestEngine(const server::EngineOptions& options) : options_(options) {
  spdlog::set_level(spdlog::level::off);
  Start();
}

TestEngine::~TestEngine() { Stop(); }

void TestEngine::Stop() {
  gate_->Open();
  model_gate_->Open();
  reading_gate_->Open();
  derive_gate_->Open();
  engine_.reset();
}

void TestEngine::Start(const absl::Status& model_fault) {
  auto store = storage::SqliteMotionStore::Open(directory_ / "store.db");
  INFO(store.status().ToString());
  REQUIRE(store.ok());
  auto gated = std::make_unique<GatedStore>(*std::move(store), gate_, model_gate_, disk_,
                                            reading_gate_, derive_gate_);
  gated->set_model_fault(model_fault);
  auto engine = server::Engine::Open(std::move(gated), options_);
  INFO(engine.status().ToString());
  REQUIRE(engine.ok());
  engine_ = *std::move(engine);
}

std::shared_ptr<server::LiveDatabase> TestEngine::Create(const std::string& id,
                                                         core::GlitchPolicy glitches) {
  const core::BuildSettings settings{.frame_rate_hz = 60, .min_frames = 4, .glitches = glitches};
  const auto record = engine_->CreateDatabase(id, settings, {server::kSourceMarkerSet, ""});
  INFO(record.status().ToString());
  REQUIRE(record.ok());
  return *engine_->FindDatabase(id);
}

absl::StatusOr<server::Ingested> TestEngine::Ingest(const std::string& database,
                                                    const std::string& name,
                                                    const StickFigure& figure) {
  const auto live = engine_->FindDatabase(database);
  if (!live.ok()) return live.status();
  const auto in_flight = engine_->BeginIngest(*live);
  if (!in_flight.ok()) return in_flight.status();
  storage::NewClip clip;
  clip.record.file_name = name + ".bvh";
  clip.record.label = name;
  clip.file_bytes = WriteBvh(figure);
  return engine_->Ingest(*live, {std::move(clip)}, {});
}

storage::OperationRecord TestEngine::Wait(const std::string& operation) {
  std::promise<absl::StatusOr<storage::OperationRecord>> ended;
  server::OperationWait::Start(engine_->workers(), engine_->operations(), operation,
                               std::chrono::minutes(1),
                               [&](auto record) { ended.set_value(std::move(record)); });
  auto record = ended.get_future().get();
  INFO(record.status().ToString());
  REQUIRE(record.ok());
  return *std::move(record);
}

int TestEngine::ModelVersion(const std::string& database) {
  const auto snapshot = (*engine_->FindDatabase(database))->lifecycle().snapshot();
  return snapshot == nullptr ? 0 : snapshot->record.version;
}

}  // namespace motiondb::tests
