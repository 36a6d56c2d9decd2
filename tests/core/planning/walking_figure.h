// A synthetic walker with known foot contacts: legs, feet and a head.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/model/model_builder.h"
#include "core/planning/contacts.h"

namespace motiondb::tests {

// Markers of one side in this order, after the head; first left, then right.
enum WalkerMarker { kHip, kThigh, kKnee, kShin, kAnkle, kHeel, kToe, kWalkerMarkers };

inline int WalkerIndex(int side, WalkerMarker marker) { return 1 + side * kWalkerMarkers + marker; }

inline core::MarkerSet WalkerSet() {
  core::MarkerSet set;
  set.name = "walker";
  set.markers = {"Head"};
  for (const char* side : {"L", "R"}) {
    for (const char* name : {"Hip", "Thigh", "Knee", "Shin", "Ankle", "Heel", "Toe"}) {
      set.markers.push_back(std::string(side) + name);
    }
  }
  set.landmarks.left_hip = WalkerIndex(0, kHip);
  set.landmarks.right_hip = WalkerIndex(1, kHip);
  for (const int side : {0, 1}) {
    set.landmarks.legs.push_back(
        {WalkerIndex(side, kHip), WalkerIndex(side, kKnee), WalkerIndex(side, kAnkle)});
  }
  return set;
}

// Walks along x at `speed_m_s` on a floor at z = 0.
struct WalkingFigure {
  double rate_hz = 60;
  double seconds = 6;
  double speed_m_s = 0.7;
  double floor_m = 0;  // height of the floor

  static constexpr double kThigh_m = 0.45;
  static constexpr double kShin_m = 0.43;
  static constexpr double kLeg_m = kThigh_m + kShin_m;
  static constexpr double kCycle = 1.1;     // s
  static constexpr double kHeelOff = 0.42;  // fractions of a cycle after the heel's landing
  static constexpr double kToeDown = 0.08;
  static constexpr double kToeOff = 0.62;
  static constexpr double kFoot_m = 0.18;  // heel to toe
  static constexpr double kHeelRest_m = 0.035;
  static constexpr double kToeRest_m = 0.03;

  // Returns the fraction of a foot's cycle, and the number of the cycle.
  std::pair<double, double> Phase(int side, double t) const {
    const double cycles = t / kCycle + 0.5 * side + 0.31;
    return {cycles - std::floor(cycles), std::floor(cycles)};
  }

  bool Stands(int side, WalkerMarker marker, double t) const {
    const double phase = Phase(side, t).first;
    return marker == kHeel ? phase < kHeelOff : phase > kToeDown && phase < kToeOff;
  }

  core::MarkerMotion Motion() const {
    core::MarkerMotion motion{WalkerSet().markers, rate_hz, {}};
    const auto frames = static_cast<Eigen::Index>(seconds * rate_hz);
    motion.positions_m.resize(frames, 3 * static_cast<Eigen::Index>(motion.names.size()));
    for (Eigen::Index f = 0; f < frames; ++f) {
      const double t = static_cast<double>(f) / rate_hz;
      Put({speed_m_s * t, 0, 1.7}, f, 0, motion);
      for (const int side : {0, 1}) PutLeg(side, t, f, motion);
    }
    return motion;
  }

  // Returns the true contacts, in the columns of `feet`.
  core::ContactMatrix Contacts(const core::Feet& feet, Eigen::Index frames) const {
    core::ContactMatrix contacts(frames, 4);
    Eigen::Index column = 0;
    for (const core::Foot& foot : feet) {
      for (const int m : foot.contact_markers) {
        for (Eigen::Index f = 0; f < frames; ++f) {
          contacts(f, column) =
              Stands((m - 1) / kWalkerMarkers, WalkerMarker((m - 1) % kWalkerMarkers),
                     static_cast<double>(f) / rate_hz);
        }
        ++column;
      }
    }
    return contacts;
  }

  core::Model Model(core::Scaling scaling = core::Scaling::kKind) const {
    const core::MarkerSet set = WalkerSet();
    auto states = core::ComputeStates(set, Motion());
    REQUIRE(states.ok());
    core::BuildSettings settings;
    settings.frame_rate_hz = rate_hz;
    settings.min_frames = 64;
    settings.scaling = scaling;
    auto model = core::BuildModel(settings, set, {{"walk", "walk", *std::move(states)}},
                                  core::RunSerially, {});
    INFO(model.status());
    REQUIRE(model.ok());
    return *std::move(model);
  }

 private:
  void Put(Eigen::Vector3d place, Eigen::Index frame, int marker,
           core::MarkerMotion& motion) const {
    place.z() += floor_m;
    motion.positions_m.row(frame).segment<3>(3 * marker) = place.transpose().cast<float>();
  }

  static double Between(double from, double to, double at) {
    return std::clamp((at - from) / (to - from), 0.0, 1.0);
  }

  void PutLeg(int side, double t, Eigen::Index frame, core::MarkerMotion& motion) const {
    const auto [phase, cycle] = Phase(side, t);
    const double y = side == 0 ? 0.1 : -0.1;
    const double stride = speed_m_s * kCycle;
    // The heel lands in front of the hip; cycle 0 began before t = 0.
    const double landing = stride * (cycle - 0.5 * side - 0.31) + 0.3 * stride;
    constexpr double kToesUp = 0.3;  // rad, at the heel's landing
    constexpr double kHeelUp = 0.8;  // rad, at the toe's take-off
    const auto along = [](double pitch) {
      return Eigen::Vector3d(std::cos(pitch), 0, std::sin(pitch));
    };
    const Eigen::Vector3d heel_rest(landing, y, kHeelRest_m);
    const double flat = std::asin((kToeRest_m - kHeelRest_m) / kFoot_m);
    const Eigen::Vector3d toe_rest = heel_rest + kFoot_m * along(flat);
    Eigen::Vector3d heel;
    double pitch;
    if (phase < kHeelOff) {
      const double down = Between(0, kToeDown, phase);
      pitch = kToesUp + (flat - kToesUp) * down * down * (3 - 2 * down);
      heel = heel_rest;
    } else if (phase < kToeOff) {
      const double up = Between(kHeelOff, kToeOff, phase);
      pitch = flat + (-kHeelUp - flat) * up * (1 + up) / 2;
      heel = toe_rest - kFoot_m * along(pitch);
    } else {
      const double swing = Between(kToeOff, 1, phase);
      const double eased = swing * (1 + swing * (3 - 2 * swing)) / 2;  // does not start at rest
      pitch = -kHeelUp + (kToesUp + kHeelUp) * eased;
      const Eigen::Vector3d left = toe_rest - kFoot_m * along(-kHeelUp);
      const Eigen::Vector3d next = heel_rest + Eigen::Vector3d(stride, 0, 0);
      heel = left + eased * (next - left);
      heel.z() += 0.06 * std::sin(std::numbers::pi * swing);
    }
    const Eigen::Vector3d foot_up(-std::sin(pitch), 0, std::cos(pitch));
    const Eigen::Vector3d ankle = heel + 0.04 * along(pitch) + 0.06 * foot_up;
    const Eigen::Vector3d hip(speed_m_s * t, y, 0.88);
    const double distance = (ankle - hip).norm();
    REQUIRE(distance < kLeg_m);
    const Eigen::Vector3d down = (ankle - hip) / distance;
    const Eigen::Vector3d front = Eigen::Vector3d(-down.z(), 0, down.x()).normalized();
    const double forth =
        (kThigh_m * kThigh_m - kShin_m * kShin_m + distance * distance) / (2 * distance);
    const Eigen::Vector3d knee =
        hip + forth * down + std::sqrt(kThigh_m * kThigh_m - forth * forth) * front;
    Put(hip, frame, WalkerIndex(side, kHip), motion);
    Put(0.5 * (hip + knee), frame, WalkerIndex(side, kThigh), motion);
    Put(knee, frame, WalkerIndex(side, kKnee), motion);
    Put(0.5 * (knee + ankle), frame, WalkerIndex(side, kShin), motion);
    Put(ankle, frame, WalkerIndex(side, kAnkle), motion);
    Put(heel, frame, WalkerIndex(side, kHeel), motion);
    Put(heel + kFoot_m * along(pitch), frame, WalkerIndex(side, kToe), motion);
  }
};

}  // namespace motiondb::tests
