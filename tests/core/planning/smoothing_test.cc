#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/planning/splice.h"

namespace motiondb::tests::smoothing_test {

TEST_CASE("Ease: from 0 to 1, at rest at both ends", "[core][planning]") {
  CHECK(core::Ease(-1) == 0);
  CHECK(core::Ease(0.5) == Approx(0.5));
  CHECK(core::Ease(2) == 1);
  const double h = 1e-3;
  CHECK(core::Ease(h) / h < 1e-4);
  CHECK(core::Ease(h) / (h * h) < 0.02);
}

TEST_CASE("Smooth: keeps constants and the sum of an inner peak", "[core][planning]") {
  CHECK(core::Smooth(Eigen::ArrayXXd::Constant(9, 2, 3.5), 4).isApproxToConstant(3.5));
  Eigen::ArrayXXd peak = Eigen::ArrayXXd::Zero(21, 1);
  peak(10, 0) = 1;
  const Eigen::ArrayXXd smooth = core::Smooth(peak, 3);
  CHECK(smooth.sum() == Approx(1));
  CHECK(smooth(10, 0) > smooth(9, 0));
  CHECK(smooth(9, 0) == Approx(smooth(11, 0)));
  CHECK(smooth(6, 0) == 0);
}

TEST_CASE("UpperEnvelope: is never below the values", "[core][planning]") {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Eigen::ArrayXd values(200);
  for (double& value : values) value = normal(random);
  for (const int reach : {1, 5, 300}) {
    CHECK((core::UpperEnvelope(values, reach) - values).minCoeff() > -1e-12);
  }
  CHECK(core::UpperEnvelope(Eigen::ArrayXd(), 3).size() == 0);
}

}  // namespace motiondb::tests::smoothing_test
