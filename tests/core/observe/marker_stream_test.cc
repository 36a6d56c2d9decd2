#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/states.h"
#include "core/observe/observed_states.h"
#include "tests/core/observe/point_motion.h"

namespace motiondb::tests::marker_stream_test {
namespace {

core::MarkerStream Stream(double from_hz, double to_hz) {
  auto stream =
      core::MarkerStream::Create(PointScheme(), PointScheme().set.markers, from_hz, to_hz);
  INFO(stream.status());
  REQUIRE(stream.ok());
  return *std::move(stream);
}

bool Same(const Eigen::RowVectorXf& a, const Eigen::RowVectorXf& b) {
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) != std::isnan(b[i])) return false;
    if (!std::isnan(a[i]) && std::abs(a[i] - b[i]) > 1e-6F) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("MarkerStream: equals Resample, with minimum delay", "[core][observe]") {
  for (const double rate : {60.0, 120.0, 100.0, 50.0, 30.0, 25.0, 59.94, 480.0, 1.5}) {
    core::MarkerMotion motion = PointMotion(120, 3, 0, rate);
    Hide(motion, 2, 30, 34);
    Hide(motion, 3, 31, 32);
    const auto whole = core::Resample(motion, 60);
    REQUIRE(whole.ok());
    core::MarkerStream stream = Stream(rate, 60);
    Eigen::Index given = 0;
    for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
      stream.Push(motion.positions_m.row(t));
      while (const Eigen::RowVectorXf* frame = stream.Next()) {
        CAPTURE(rate, t, given);
        REQUIRE(given < whole->positions_m.rows());
        REQUIRE(Same(*frame, whole->positions_m.row(given)));
        ++given;
      }
      // The delay is at most two of its own frames.
      CHECK(static_cast<double>(given) >= (static_cast<double>(t) - 2) * 60 / rate);
    }
  }
}

TEST_CASE("MarkerStream: a marker with one NaN is missing", "[core][observe]") {
  core::MarkerStream stream = Stream(60, 60);
  core::MarkerMotion motion = PointMotion(2, 3, 0);
  motion.positions_m(0, 7) = std::nanf("");
  stream.Push(motion.positions_m.row(0));
  const Eigen::RowVectorXf* frame = stream.Next();
  REQUIRE(frame != nullptr);
  CHECK(frame->segment<3>(6).array().isNaN().all());
  CHECK(frame->head<6>().allFinite());
  stream.PushMissing();
  CHECK(stream.Next()->array().isNaN().all());
  CHECK(stream.Next() == nullptr);
}

TEST_CASE("MarkerStream: maps names by the scheme, and refuses unknown names", "[core][observe]") {
  core::MarkerScheme scheme = PointScheme();
  core::MarkerMapping mapping{"two", {"left", "right"}, {}};
  for (int m = 0; m < 6; ++m) {
    mapping.rules.push_back({{{"left", 0.25}, {"right", 0.75}}, "", Eigen::Vector3d::Zero()});
  }
  scheme.mappings.push_back(mapping);
  auto stream = core::MarkerStream::Create(scheme, {"right", "left"}, 60, 60);
  REQUIRE(stream.ok());
  CHECK(stream->source_width() == 6);
  stream->Push(Eigen::RowVectorXf::LinSpaced(6, 0, 5));
  CHECK((*stream->Next())[0] == Approx(0.75));

  using Catch::Matchers::Contains;
  CHECK_THAT(std::string(core::MarkerStream::Create(scheme, {"other"}, 60, 60).status().message()),
             Contains("no mapping"));
  for (const double rate : {1e-9, 1e9, 0.0, -60.0, std::nan(""), HUGE_VAL}) {
    CAPTURE(rate);
    const auto refused = core::MarkerStream::Create(scheme, {"right", "left"}, rate, 60);
    CHECK(refused.status().code() == absl::StatusCode::kInvalidArgument);
    CHECK_THAT(std::string(refused.status().message()), Contains("frame_rate_hz"));
  }
}

}  // namespace motiondb::tests::marker_stream_test
