// An engine without transport, over a real store in a temporary file.
#pragma once

#include <memory>
#include <string>

#include "server/engine/engine.h"
#include "tests/support/full_disk.h"
#include "tests/support/gated_store.h"
#include "tests/support/stick_figure.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {

class TestEngine {
 public:
  explicit TestEngine(const server::EngineOptions& options = QuickOptions());
  ~TestEngine();

  // Rebuilds 50 ms after the last ingest; never extends, however slow the machine is.
  static server::EngineOptions QuickOptions();

  // Stops the engine; starts a new one on the same file. Reads of models fail with `model_fault`.
  void Stop();
  void Start(const absl::Status& model_fault = absl::OkStatus());

  server::Engine* operator->() { return engine_.get(); }
  server::Engine& operator*() { return *engine_; }
  std::string store_path() const { return directory_ / "store.db"; }
  Gate& gate() { return *gate_; }
  Gate& model_gate() { return *model_gate_; }
  Gate& reading_gate() { return *reading_gate_; }
  Gate& derive_gate() { return *derive_gate_; }
  SimulatedDisk& disk() { return *disk_; }
  // Applied by the next Start.
  void set_options(const server::EngineOptions& options) { options_ = options; }

  // Creates a `source` database with small nodes.
  std::shared_ptr<server::LiveDatabase> Create(
      const std::string& id, core::GlitchPolicy glitches = core::GlitchPolicy::kRepair);
  // Ingests a figure as NAME.bvh with label NAME.
  absl::StatusOr<server::Ingested> Ingest(const std::string& database, const std::string& name,
                                          const StickFigure& figure);
  // Waits at most 1 minute until the operation is done or the engine drains.
  storage::OperationRecord Wait(const std::string& operation);
  // Returns the version of the current model, or 0.
  int ModelVersion(const std::string& database);

 private:
  server::EngineOptions options_;
  TemporaryDirectory directory_;
  const std::shared_ptr<Gate> gate_ = std::make_shared<Gate>();
  const std::shared_ptr<Gate> model_gate_ = std::make_shared<Gate>();
  const std::shared_ptr<Gate> reading_gate_ = std::make_shared<Gate>();
  const std::shared_ptr<Gate> derive_gate_ = std::make_shared<Gate>();
  const std::shared_ptr<SimulatedDisk> disk_ = std::make_shared<SimulatedDisk>();
  std::unique_ptr<server::Engine> engine_;
};

}  // namespace motiondb::tests
