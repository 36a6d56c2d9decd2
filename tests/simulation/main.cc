// Runs seeds of the simulation. Exits with 1 at the first broken invariant, after printing its
// seed.
#include <fmt/format.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "tests/simulation/simulation.h"
#include "tests/simulation/world.h"

namespace {

// Prints log lines with their server. They are not part of the trace: some have random names.
class TraceSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const auto* const process = motiondb::simulation::World::Current().process();
    fmt::print("           {:3} {}\n", process == nullptr ? "-" : process->name,
               std::string_view(message.payload.data(), message.payload.size()));
  }
  void flush_() override {}
};

}  // namespace

int main(int argc, char** argv) {
  using motiondb::simulation::Protection;
  CLI::App app{"Simulates several servers on one store. The same seed gives the same run."};
  std::uint64_t seeds = 300;
  std::uint64_t first = 1;
  auto removed = Protection::kNone;
  bool trace = false;
  app.add_option("--seeds", seeds, "Number of seeds")->capture_default_str();
  app.add_option("--first", first, "First seed")->capture_default_str();
  const std::map<std::string, Protection> protections = {
      {"fence", Protection::kFence},
      {"compare-and-set", Protection::kCompareAndSet},
      {"revision", Protection::kRevision},
      {"database", Protection::kDatabase},
      {"revocation", Protection::kRevocation}};
  app.add_option("--without", removed, "Protection of the store to remove: a seed must then fail")
      ->transform(CLI::CheckedTransformer(protections));
  app.add_flag("--trace", trace, "Print the events and the log of the servers");
  CLI11_PARSE(app, argc, argv);

  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("servers", std::make_shared<TraceSink>()));
  spdlog::set_level(trace ? spdlog::level::info : spdlog::level::off);
  motiondb::simulation::World::set_prints_trace(trace);
  std::uint64_t hash = 0;
  for (std::uint64_t seed = first; seed < first + seeds; ++seed) {
    hash = hash * 31 + motiondb::simulation::Simulate(seed, removed);
  }
  fmt::print("{} seeds keep all invariants; hash of their traces: {:016x}\n", seeds, hash);
  return 0;
}
