#include "tests/fuzz/server/trained_engine.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <thread>

#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/fuzz/support/properties.h"
#include "tests/support/stick_figure.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {
namespace {

constexpr int kMaxFrames = 2000;  // of an observation; the time limit of a target allows no more

void Ingest(TrainedEngine& trained, const std::string& name, const StickFigure& figure) {
  storage::NewClip clip;
  clip.record.file_name = name + ".bvh";
  clip.record.label = name;
  clip.file_bytes = WriteBvh(figure);
  const auto in_flight = trained.engine->BeginIngest(trained.database);
  CheckContract(in_flight.ok(), "an ingest begins");
  CheckContract(trained.engine->Ingest(trained.database, {std::move(clip)}, {}).ok(),
                "a figure is stored");
}

TrainedEngine Train() {
  spdlog::set_level(spdlog::level::off);
  server::EngineOptions options;
  options.rebuild_delay = std::chrono::milliseconds(0);
  options.extend_from = std::chrono::hours(1);
  options.query_threads = 1;
  options.build_threads = 1;
  options.max_frames = kMaxFrames;
  TrainedEngine trained;
  static const TemporaryDirectory kDirectory;  // removed at exit
  auto store = storage::SqliteMotionStore::Open(kDirectory / "store.db");
  CheckContract(store.ok(), "a store opens");
  auto engine = server::Engine::Open(*std::move(store), options);
  CheckContract(engine.ok(), "an engine opens");
  trained.engine = *std::move(engine);
  const core::BuildSettings settings{.frame_rate_hz = 60, .min_frames = 4};
  CheckContract(trained.engine->CreateDatabase("db", settings, {server::kSourceMarkerSet, ""}).ok(),
                "a database is created");
  trained.database = *trained.engine->FindDatabase("db");
  Ingest(trained, "walk", {.act = Act::kWalk, .frame_count = 90});
  Ingest(trained, "squat", {.act = Act::kSquat, .frame_count = 90});
  Ingest(trained, "wave", {.act = Act::kWave, .frame_count = 90});
  while (true) {
    trained.snapshot = trained.database->lifecycle().snapshot();
    const bool is_stored = trained.snapshot != nullptr && trained.snapshot->is_stored();
    if (is_stored && trained.model().clips().size() == 3) return trained;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace

TrainedEngine& Trained() {
  static auto* const kTrained = new TrainedEngine(Train());  // outlives the threads at exit
  return *kTrained;
}

}  // namespace motiondb::tests

// Before the first input, so that training does not count as its time.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  motiondb::tests::Trained();
  return 0;
}
