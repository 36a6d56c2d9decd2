#include "tests/bench/varied_motion.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "core/format/marker_set_file.h"
#include "core/motion/error.h"
#include "core/motion/mirror.h"
#include "core/planning/seeded.h"
#include "tests/bench/body_variation.h"
#include "tests/bench/take.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {
namespace {

constexpr int kMinFrames = 8;         // of a clip
constexpr double kFadeSeconds = 0.4;  // between takes
constexpr double kTakeSeconds = 1.2;  // the shortest take: room for a fade at both ends
constexpr int kFollowers = 8;         // candidates for the next take

int Below(int count, core::SeededSequence& random) {
  return static_cast<int>(random.Next() * count);
}

// The source of all varied clips.
struct Source {
  std::vector<Take> takes[2];  // as recorded, mirrored
  std::map<std::string, std::vector<int>> of_label;
  std::vector<Bone> bones;
};

absl::StatusOr<Source> LoadSource(const std::filesystem::path& data, double frame_rate_hz,
                                  const core::ParallelFor& parallel) {
  MOTIONDB_ASSIGN_OR_RETURN(const Corpus corpus,
                            LoadRecognitionCorpus(data, frame_rate_hz, parallel));
  const std::vector<int> other_sides = core::OtherSides(corpus.set.markers);
  Source source;
  MOTIONDB_ASSIGN_OR_RETURN(source.bones, StandardBones(corpus.set));
  std::set<std::string> seen;  // a clip may be in two lists
  for (const auto& clip : corpus.clips) {
    if (clip->states.frame_count() < kTakeSeconds * frame_rate_hz) continue;
    if (!seen.insert(clip->name).second) continue;
    Take take = MakeTake(clip->label, clip->source, clip->states);
    source.of_label[take.label].push_back(static_cast<int>(source.takes[0].size()));
    source.takes[1].push_back(MirroredTake(other_sides, take));
    source.takes[0].push_back(std::move(take));
  }
  if (source.takes[0].empty()) {
    return core::InvalidArgument("{}: expected a clip of at least {} s", data.string(),
                                 kTakeSeconds);
  }
  return source;
}

// Takes of one label in sequence, at a smoothly varying speed.
class Performance {
 public:
  Performance(const std::vector<Take>& takes, const std::vector<int>& of_label, int first,
              double frame_rate_hz, core::SeededSequence& random)
      : takes_(takes),
        of_label_(of_label),
        fade_(kFadeSeconds * frame_rate_hz),
        random_(random),
        speed_(random),
        now_(Enter(first)) {}

  // Returns the pose at the next frame and the step from it, as in Take.
  void Next(double seconds, Eigen::RowVectorXf& pose, Eigen::RowVector3f& step) {
    // 0.7 to 1.4, uniform in the logarithm.
    const double speed =
        std::exp(0.5 * std::log(0.7 * 1.4) + 0.5 * std::log(1.4 / 0.7) * speed_.At(seconds));
    if (now_.at >= takes_[now_.take].last_frame()) {
      now_ = next_;
      fading_ = false;
    }
    SampleTake(takes_[now_.take], now_.at, pose, step);
    const double fade_begin = takes_[now_.take].last_frame() - fade_;
    if (const double into = (now_.at - fade_begin) / fade_; into > 0) {
      if (!fading_) next_ = Follow(pose);
      fading_ = true;
      SampleTake(takes_[next_.take], next_.at, other_pose_, other_step_);
      const auto share = static_cast<float>(into * into * (3 - 2 * into));
      pose += share * (other_pose_ - pose);
      step += share * (other_step_ - step);
      next_.at += speed;
    }
    now_.at += speed;
    step *= static_cast<float>(speed);
  }

 private:
  struct Place {
    int take = 0;
    double at = 0;  // frames
  };

  // Enters early: the fade in must end before the fade out begins.
  Place Enter(int take) {
    const double last = takes_[take].last_frame();
    return {take, random_.Between(0, std::min(0.3 * last, last - 2.5 * fade_))};
  }

  // Returns the place with the nearest pose of some candidates of the label.
  Place Follow(const Eigen::RowVectorXf& pose) {
    Place best;
    float nearest = INFINITY;
    for (int i = 0; i < kFollowers; ++i) {
      const Place place = Enter(of_label_[Below(static_cast<int>(of_label_.size()), random_)]);
      SampleTake(takes_[place.take], place.at, other_pose_, other_step_);
      const float distance = (other_pose_ - pose).squaredNorm();
      if (distance < nearest) {
        nearest = distance;
        best = place;
      }
    }
    return best;
  }

  const std::vector<Take>& takes_;
  const std::vector<int>& of_label_;
  double fade_;  // frames
  core::SeededSequence& random_;
  Wave speed_;
  Place now_;
  Place next_;
  bool fading_ = false;
  Eigen::RowVectorXf other_pose_;
  Eigen::RowVector3f other_step_;
};

// Takes are used in turn, so that each begins the same number of clips.
absl::Status VaryClip(const Source& source, int clip, int frames, double frame_rate_hz,
                      std::uint64_t seed, core::BuildInput& input) {
  core::SeededSequence random(core::Mix(seed) + static_cast<std::uint64_t>(clip));
  const std::vector<Take>& takes = source.takes[Below(2, random)];
  const int first = clip % static_cast<int>(takes.size());
  const std::vector<int>& of_label = source.of_label.at(takes[first].label);
  const Take& other = takes[of_label[Below(static_cast<int>(of_label.size()), random)]];
  const BodyVariation body(source.bones, takes[first].pose.colwise().mean(),
                           other.pose.colwise().mean(), random);
  const double leg_length_m = takes[first].leg_length_m * random.Between(0.85, 1.15);
  Performance performance(takes, of_label, first, frame_rate_hz, random);

  const core::MarkerSet& set = core::StandardScheme().set;
  core::MarkerMotion motion{set.markers, frame_rate_hz, {}};
  motion.positions_m.resize(frames, takes[first].pose.cols());
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double heading = 0;
  Eigen::RowVectorXf pose, scratch;
  Eigen::RowVector3f step;
  for (int t = 0; t < frames; ++t) {
    const double seconds = t / frame_rate_hz;
    performance.Next(seconds, pose, step);
    body.Apply(seconds, pose, scratch);
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(heading).toRotationMatrix();
    for (Eigen::Index m = 0; m < pose.size(); m += 3) {
      Eigen::Vector3d p = leg_length_m * pose.segment<3>(m).cast<double>().transpose();
      p.head<2>() = turn * p.head<2>() + origin;
      motion.positions_m.row(t).segment<3>(m) = p.cast<float>().transpose();
    }
    origin += leg_length_m * (turn * step.head<2>().cast<double>().transpose());
    heading += step[2];
  }
  input.clip_id = fmt::format("varied-{:05}", clip);
  input.labels = takes[first].label;
  input.subject = takes[first].subject;
  MOTIONDB_ASSIGN_OR_RETURN(input.states, core::ComputeStates(set, motion));
  return absl::OkStatus();
}

// Returns the frames of each clip: 0.5 to 1.5 times the mean, with the requested sum.
std::vector<int> Lengths(const VariedSize& size, std::uint64_t seed) {
  core::SeededSequence random(seed);
  std::vector<double> share(size.clips);
  double sum = 0;
  for (double& s : share) sum += s = random.Between(0.5, 1.5);
  std::vector<int> lengths;
  double until = 0;
  int taken = 0;
  const double spare = size.frames - static_cast<double>(kMinFrames) * size.clips;
  for (int c = 0; c < size.clips; ++c) {
    until += share[c] / sum * spare;
    const int end = c + 1 == size.clips ? static_cast<int>(spare) : static_cast<int>(until);
    lengths.push_back(kMinFrames + end - taken);
    taken = end;
  }
  return lengths;
}

}  // namespace

absl::StatusOr<std::vector<core::BuildInput>> VariedClips(const std::filesystem::path& data,
                                                          const VariedSize& size,
                                                          std::uint64_t seed,
                                                          const core::ParallelFor& parallel) {
  if (size.clips < 1 || size.frames / size.clips < kMinFrames) {
    return core::InvalidArgument(
        "expected at least one clip and at least {} frames per clip, got {} frames in {} clips",
        kMinFrames, size.frames, size.clips);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const Source source, LoadSource(data, size.frame_rate_hz, parallel));
  const std::vector<int> lengths = Lengths(size, seed);
  std::vector<core::BuildInput> clips(size.clips);
  std::vector<absl::Status> statuses(size.clips);
  parallel(size.clips, [&](int c) {
    statuses[c] = VaryClip(source, c, lengths[c], size.frame_rate_hz, seed, clips[c]);
  });
  for (const absl::Status& status : statuses) MOTIONDB_RETURN_IF_ERROR(status);
  return clips;
}

absl::StatusOr<core::FrameMatrix> VariedStates(const std::filesystem::path& data,
                                               const VariedSize& size, std::uint64_t seed,
                                               const core::ParallelFor& parallel,
                                               core::Scaling scaling) {
  MOTIONDB_ASSIGN_OR_RETURN(std::vector<core::BuildInput> clips,
                            VariedClips(data, size, seed, parallel));
  core::FrameMatrix states(size.frames, clips.front().states.states.cols());
  Eigen::Index row = 0;
  for (core::BuildInput& clip : clips) {
    const core::FrameMatrix rows = std::move(clip.states.states);
    states.middleRows(row, rows.rows()) = rows;
    row += rows.rows();
  }
  core::MakeFeatureScale(scaling, states).Apply(states);
  return states;
}

}  // namespace motiondb::tests
