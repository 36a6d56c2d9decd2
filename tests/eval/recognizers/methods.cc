#include "tests/eval/recognizers/methods.h"

#include <fmt/format.h>

#include "tests/eval/peers/hmm_per_label.h"
#include "tests/eval/peers/subsequence_dtw.h"
#include "tests/eval/peers/windowed_nearest.h"
#include "tests/eval/recognizers/database_recognizer.h"
#include "tests/eval/recognizers/tuned_peer.h"

namespace motiondb::tests {
namespace {

// Returns one candidate per scaling of the states.
template <typename Nearest>
std::vector<PeerCandidate> ScaledCandidates() {
  std::vector<PeerCandidate> candidates;
  for (const auto& [scaling, name] : {std::pair{core::Scaling::kKind, "scale by kind"},
                                      std::pair{core::Scaling::kDimension, "scale by dimension"}}) {
    candidates.push_back(
        {name, [scaling = scaling] { return std::make_unique<Nearest>(scaling); }});
  }
  return candidates;
}

std::vector<PeerCandidate> HmmCandidates() {
  std::vector<PeerCandidate> candidates;
  for (const Topology topology : {Topology::kLeftRight, Topology::kErgodic}) {
    for (const int states : {2, 4, 8, 16}) {
      for (const double floor : {0.1, 0.3}) {
        const HmmOptions options{.states = states, .topology = topology, .variance_floor = floor};
        candidates.push_back(
            {fmt::format("{} states, {}, variance floor {}", states,
                         topology == Topology::kLeftRight ? "left-right" : "ergodic", floor),
             [options] { return std::make_unique<HmmPerLabel>(options); }});
      }
    }
  }
  return candidates;
}

RecognitionMethod PeerMethod(std::string name, std::vector<PeerCandidate> candidates) {
  return {std::move(name), [candidates] { return std::make_unique<TunedPeer>(candidates); }, true};
}

}  // namespace

std::vector<RecognitionMethod> RecognitionMethods(const core::MarkerSet& set) {
  std::vector<RecognitionMethod> methods = DatabaseMethods(set);
  methods.push_back(PeerMethod("windowed 1-NN", ScaledCandidates<WindowedNearest>()));
  methods.push_back(PeerMethod("DTW 1-NN", ScaledCandidates<SubsequenceDtw>()));
  methods.push_back(PeerMethod("Gaussian HMM", HmmCandidates()));
  return methods;
}

}  // namespace motiondb::tests
