#include "tests/core/observe/observing.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

namespace motiondb::tests {

std::unique_ptr<core::Observer> Observe(const core::Model& model,
                                        const core::ObserverOptions& options,
                                        std::optional<double> leg_length_m, double rate) {
  auto observer = core::Observer::Create(model, PointScheme(), PointScheme().set.markers, rate,
                                         leg_length_m, options);
  INFO(observer.status());
  REQUIRE(observer.ok());
  return *std::move(observer);
}

void Append(core::Observer& observer, std::int64_t first_frame, const core::FrameMatrix& frames) {
  const absl::Status status = observer.Append(first_frame, frames);
  INFO(status);
  REQUIRE(status.ok());
}

core::Observed Answer(core::Observer& observer) {
  auto answer = observer.Answer();
  INFO(answer.status());
  REQUIRE(answer.ok());
  REQUIRE(answer->has_value());
  return **std::move(answer);
}

void CheckLabels(const std::vector<core::LabelScore>& a, const std::vector<core::LabelScore>& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t l = 0; l < a.size(); ++l) {
    if (std::abs(a[l].probability - b[l].probability) < 1e-9) continue;
    CHECK(a[l].label == b[l].label);
    CHECK(a[l].probability == Approx(b[l].probability).epsilon(1e-3).margin(1e-7));
  }
}

void CheckSame(const core::Observed& a, const core::Observed& b) {
  CHECK(a.state.node == b.state.node);
  CHECK(a.state.probability == Approx(b.state.probability).margin(1e-6));
  CheckLabels(a.labels, b.labels);
  CHECK(a.familiarity == Approx(b.familiarity).margin(0.003));
  REQUIRE(a.horizons.size() == b.horizons.size());
  for (std::size_t h = 0; h < a.horizons.size(); ++h) {
    CHECK(a.horizons[h].seconds == b.horizons[h].seconds);
    CHECK((a.horizons[h].marker_positions_m - b.horizons[h].marker_positions_m).norm() < 1e-4);
    CHECK(a.horizons[h].extrapolated == b.horizons[h].extrapolated);
    CHECK(a.horizons[h].confidence.value_or(-1) ==
          Approx(b.horizons[h].confidence.value_or(-1)).margin(1e-4));
  }
}

core::MarkerMotion Stream(int frames) {
  core::MarkerMotion motion = PointMotion(frames, 1, 77);
  Hide(motion, 3, 50, 60);
  Hide(motion, 5, 55, 56);
  return motion;
}

}  // namespace motiondb::tests
