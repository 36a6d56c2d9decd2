#include "core/planning/time_law.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

namespace motiondb::core::time_law_test {
namespace {

constexpr double kRate = 60;
constexpr double kNone = std::numeric_limits<double>::infinity();

RateLimits Limits(Eigen::Index coordinates, double speed, double acceleration) {
  return {Eigen::RowVectorXd::Constant(coordinates, speed),
          Eigen::RowVectorXd::Constant(coordinates, acceleration)};
}

JointMatrix RandomSteps(std::mt19937& random, Eigen::Index steps, Eigen::Index coordinates) {
  std::normal_distribution<double> normal(0, 0.02);
  JointMatrix all = JointMatrix::Zero(steps, coordinates);
  for (Eigen::Index t = 0; t < steps; ++t) {
    for (Eigen::Index c = 0; c < coordinates; ++c) {
      // Changes little, with rare jumps.
      all(t, c) = (t > 0 ? 0.9 * all(t - 1, c) : 0) + normal(random);
      if (random() % 40 == 0) all(t, c) += 50 * normal(random);
    }
  }
  return all;
}

// First and second derivative of the spline with respect to the place.
struct Derivatives {
  Eigen::RowVectorXd first;
  Eigen::RowVectorXd second;
};

Derivatives At(const JointMatrix& steps, double place) {
  const Eigen::Index last = steps.rows() - 1;
  const Eigen::Index i = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(place), 0, last);
  const double f = place - static_cast<double>(i);
  const Eigen::RowVectorXd before = steps.row(std::max<Eigen::Index>(0, i - 1));
  const Eigen::RowVectorXd own = steps.row(i);
  const Eigen::RowVectorXd after = steps.row(std::min(last, i + 1));
  return {before * (1 - f) * (1 - f) / 2 + own * (1 + 2 * f - 2 * f * f) / 2 + after * f * f / 2,
          (own - before) * (1 - f) + (after - own) * f};
}

TEST_CASE("TimeLaw: random paths stay within speeds and accelerations, and never gain time",
          "[core][planning]") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const JointMatrix steps = RandomSteps(random, 40, 3);
    const double speed = trial % 3 == 0 ? kNone : 0.5 + trial % 5;
    const double acceleration = trial % 4 == 0 ? kNone : 5.0 * (1 + trial % 7);
    const TimeLaw law(steps, kRate, Limits(3, speed, acceleration));
    CHECK(law.duration_seconds() >= 40 / kRate - 1e-12);
    CHECK(law.PlaceAt(0) == 0);
    CHECK(law.PlaceAt(law.duration_seconds()) == Approx(40));
    constexpr double kStep = 1e-4;
    double largest_speed = 0;
    double largest_acceleration = 0;
    double largest_rate = 0;
    for (double t = kStep; t + kStep < law.duration_seconds(); t += 7 * kStep) {
      const double before = law.PlaceAt(t - kStep);
      const double place = law.PlaceAt(t);
      const double after = law.PlaceAt(t + kStep);
      const double rate = (after - before) / (2 * kStep);
      const double change = (after - 2 * place + before) / (kStep * kStep);
      const Derivatives path = At(steps, place);
      largest_rate = std::max(largest_rate, rate);
      largest_speed = std::max(largest_speed, rate * path.first.cwiseAbs().maxCoeff());
      largest_acceleration =
          std::max(largest_acceleration,
                   (path.second * rate * rate + path.first * change).cwiseAbs().maxCoeff());
    }
    CAPTURE(trial);
    CHECK(largest_rate <= kRate * 1.0001);
    CHECK(largest_speed <= 1.0001 * speed);
    CHECK(largest_acceleration <= 1.0001 * acceleration);
  }
}

TEST_CASE("TimeLaw: without a limit the time is as recorded", "[core][planning]") {
  std::mt19937 random(2);
  const JointMatrix steps = RandomSteps(random, 30, 2);
  const TimeLaw law(steps, kRate, Limits(2, kNone, kNone));
  CHECK(law.as_recorded());
  CHECK(law.duration_seconds() == Approx(30 / kRate));
  for (int i = 0; i <= 30; ++i) CHECK(law.PlaceAt(i / kRate) == Approx(i).margin(1e-9));
}

TEST_CASE("TimeLaw: a uniform path at twice the limit takes twice the time", "[core][planning]") {
  const JointMatrix steps = JointMatrix::Constant(30, 1, 0.1);  // 6 rad/s
  const TimeLaw law(steps, kRate, Limits(1, 3, kNone));
  CHECK(law.duration_seconds() == Approx(2 * 30 / kRate));
  REQUIRE(law.slowed().size() == 1);
  CHECK(law.slowed()[0].limit == BindingLimit{0, LimitKind::kSpeed});
  CHECK(law.slowed()[0].start_seconds == 0);
  CHECK(law.slowed()[0].end_seconds == Approx(law.duration_seconds()));
  CHECK(law.slowed()[0].factor == Approx(2));
}

TEST_CASE("TimeLaw: only the part that is too fast is slowed, and its joint is named",
          "[core][planning]") {
  JointMatrix steps = JointMatrix::Constant(120, 2, 0.01);
  steps.col(1).segment(58, 4).setConstant(0.2);  // 12 rad/s
  const TimeLaw law(steps, kRate, Limits(2, 3, kNone));
  REQUIRE(law.slowed().size() == 1);
  const SlowedPart& part = law.slowed()[0];
  CHECK(part.limit == BindingLimit{1, LimitKind::kSpeed});
  CHECK(part.factor == Approx(4).epsilon(0.05));
  CHECK(part.start_seconds > 40 / kRate);
  CHECK(law.duration_seconds() - part.end_seconds > 40 / kRate);
  // The speed of the place changes by the recorded speed in 0.2 s.
  const double change =
      (law.PlaceAt(part.start_seconds + 0.02) - 2 * law.PlaceAt(part.start_seconds + 0.01) +
       law.PlaceAt(part.start_seconds)) /
      1e-4;
  CHECK(change == Approx(-kRate / 0.2).epsilon(0.05));
}

TEST_CASE("TimeLaw: accelerations are named", "[core][planning]") {
  JointMatrix steps = JointMatrix::Zero(60, 1);
  for (int t = 0; t < 60; ++t) steps(t, 0) = 0.05 * std::sin(0.5 * t);
  const TimeLaw law(steps, kRate, Limits(1, kNone, 20));
  REQUIRE_FALSE(law.slowed().empty());
  for (const SlowedPart& part : law.slowed()) {
    CHECK(part.limit == BindingLimit{0, LimitKind::kAcceleration});
    CHECK(part.factor > 1);
    CHECK(part.end_seconds > part.start_seconds);
  }
}

TEST_CASE("TimeLaw: Slow scales times and factors", "[core][planning]") {
  TimeLaw law(JointMatrix::Constant(30, 1, 0.1), kRate, Limits(1, 3, kNone));
  const double duration = law.duration_seconds();
  const double place = law.PlaceAt(0.3);
  law.Slow(1.5);
  CHECK(law.duration_seconds() == Approx(1.5 * duration));
  CHECK(law.PlaceAt(0.45) == Approx(place));
  CHECK(law.slowed()[0].factor == Approx(3));
}

}  // namespace
}  // namespace motiondb::core::time_law_test
