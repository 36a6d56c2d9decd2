#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/calibration/recognition_fit.h"
#include "core/model/clip_mask.h"
#include "core/model/label_units.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/samples.h"
#include "core/motion/states.h"
#include "core/recognition/beginning_alignment.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/shortlist.h"
#include "core/recognition/unknown.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {
namespace {

constexpr int kMaxRecognizedUnits = 128;
constexpr int kMinWholeClips = 8;
constexpr int kMaxWholeClips = 64;
constexpr int kMaxWindows = 512;
constexpr double kWindowSeconds = 0.4;
constexpr double kMinWindowDistance = 0.2;  // s; closer windows add little information
constexpr double kBeginnings[] = {0.1, 0.2, 0.4, 0.6, 0.8, 1};
// Shorter beginnings of different behaviours are often alike, so they are left out for unknown
// motion.
constexpr double kMinUnknownBeginning = 0.4;
// Without a label's units, a shortlist must still have this many units, or all that there are.
constexpr std::size_t kMinOtherUnits = 16;
constexpr double kPowers[] = {0, 0.25, 0.5, 0.75, 1};

constexpr double kMaxWholeSeconds = 20;  // the rest of a longer clip is not used
// Maximum number of compared pairs of frames: a frame of an observation, and a frame of a clip that
// the observation is aligned with.
constexpr double kMaxComparisons = 6e9;

// Results of held-out observations.
struct TrialResults {
  std::vector<JudgedSample> samples;  // of units whose label remains in the model
  std::vector<float> familiarity;
  std::vector<UnknownSample> unknown;

  void Append(const TrialResults& other) {
    samples.insert(samples.end(), other.samples.begin(), other.samples.end());
    familiarity.insert(familiarity.end(), other.familiarity.begin(), other.familiarity.end());
    unknown.insert(unknown.end(), other.unknown.begin(), other.unknown.end());
  }
};

// Recognizes parts of a unit with the model without the clips of LeftOutWith.
class HeldOutUnit {
 public:
  // `with_unknown`: also collect UnknownSamples.
  HeldOutUnit(const Model& model, const LabelUnit& unit, bool with_unknown)
      : model_(model),
        units_(*model.action_units()),
        unit_(unit),
        with_unknown_(with_unknown),
        units_of_label_(units_.labels().size()) {
    std::vector<bool> left_out = LeftOutWith(model, unit);
    mask_ = MaskWithout(model, left_out);
    for (std::size_t c = 0; c < left_out.size(); ++c) {
      if (left_out[c]) continue;
      left_out[c] = true;  // unless it has a part with another label
      for (const LabelUnit& kept : units_.of_clip(static_cast<int>(c))) {
        if (kept.label >= 0) ++units_of_label_[kept.label];
        if (kept.label >= 0 && kept.label == unit.label) continue;
        ++other_units_;
        try_unknown_ = try_unknown_ || (kept.label >= 0 && unit.label >= 0);
        left_out[c] = false;
      }
    }
    has_label_ = unit.label >= 0 && units_of_label_[unit.label] > 0;
    mask_with_label_ = MaskWithout(model, std::move(left_out));
  }

  // Recognizes windows of `width` frames that begin at the frames `firsts` (ascending). `scaled`:
  // scaled states of the unit.
  TrialResults Windows(const FrameMatrix& scaled, const std::vector<int>& firsts, int width) const {
    TrialResults results;
    if (mask_ == nullptr) return results;
    const int stride = FrameStride(model_.settings().frame_rate_hz);
    const auto observation = MetricObservation::Create(model_, scaled);
    for (const int first : firsts) {
      const std::vector<int> compared = ComparedFrames(first, width, stride, false);
      const auto alignment =
          AlignWindow(model_, units_, *observation, compared, mask_.get(), false, {});
      Add(*alignment, results);
      if (!with_unknown_) continue;
      AddKnown(*alignment, results);
      if (!try_unknown_) continue;
      WindowAlignment others = WithoutLabel(*alignment);
      if (LacksClips(others)) {
        others = *AlignWindow(model_, units_, *observation, compared, mask_with_label_.get(), false,
                              {}, unit_.label);
      }
      AddUnknown(others, results);
    }
    return results;
  }

  // Recognizes the kBeginnings of the unit as whole observations. Only the first kMaxWholeSeconds
  // of the unit are used.
  TrialResults Beginnings(const StateSequence& motion) const {
    TrialResults results;
    if (mask_ == nullptr) return results;
    const int frames = std::min(
        motion.frame_count(),
        std::max(1, static_cast<int>(std::lround(kMaxWholeSeconds * motion.frame_rate_hz))));
    core::Beginnings beginnings{motion.states.topRows(frames), {}, {}};
    model_.scale().Apply(beginnings.states);
    beginnings.newest.resize(std::ssize(kBeginnings), motion.states.cols());
    for (const double share : kBeginnings) {
      const int length =
          std::clamp(static_cast<int>(std::lround(share * frames)), std::min(2, frames), frames);
      beginnings.newest.row(std::ssize(beginnings.lengths)) = PastAt(motion, length - 1, 1).states;
      beginnings.lengths.push_back(length);
    }
    model_.scale().Apply(beginnings.newest);
    const std::vector<WindowAlignment> alignments =
        AlignBeginnings(model_, units_, beginnings, mask_.get());
    for (const WindowAlignment& alignment : alignments) Add(alignment, results);
    if (!with_unknown_) return results;

    std::vector<WindowAlignment> others;
    others.reserve(alignments.size());
    for (const WindowAlignment& alignment : alignments) others.push_back(WithoutLabel(alignment));
    if (try_unknown_ && std::ranges::any_of(others, [&](const WindowAlignment& alignment) {
          return LacksClips(alignment);
        })) {
      others = AlignBeginnings(model_, units_, beginnings, mask_with_label_.get(), unit_.label);
    }
    for (std::size_t b = 0; b < alignments.size(); ++b) {
      if (kBeginnings[b] < kMinUnknownBeginning) continue;
      AddKnown(alignments[b], results);
      if (try_unknown_) AddUnknown(others[b], results);
    }
    return results;
  }

 private:
  void Add(const WindowAlignment& alignment, TrialResults& results) const {
    results.familiarity.push_back(static_cast<float>(alignment.familiarity_score));
    if (!has_label_) return;
    results.samples.push_back(
        {LabelEvidence(units_.labels().size(), alignment.units), label(), alignment.frames});
  }

  // Index of the label. REQUIRES: the unit has one.
  std::size_t label() const { return static_cast<std::size_t>(unit_.label); }

  // Removes the units of the label. The evidence of the others does not change.
  WindowAlignment WithoutLabel(const WindowAlignment& alignment) const {
    WindowAlignment others = alignment;
    std::erase_if(others.units, [&](const UnitEvidence& other) {
      return unit_.label >= 0 && other.unit->label == unit_.label;
    });
    return others;
  }

  bool LacksClips(const WindowAlignment& others) const {
    return others.units.size() < std::min(kMinOtherUnits, other_units_);
  }

  // Returns the evidence of each label; -infinity without units.
  std::vector<double> EvidenceOf(const WindowAlignment& alignment, bool is_unknown) const {
    std::vector<double> evidence = LabelEvidence(units_.labels().size(), alignment.units);
    for (std::size_t l = 0; l < evidence.size(); ++l) {
      if (units_of_label_[l] == 0 || (is_unknown && l == label())) {
        evidence[l] = -std::numeric_limits<double>::infinity();
      }
    }
    return evidence;
  }

  void AddKnown(const WindowAlignment& alignment, TrialResults& results) const {
    if (!has_label_) return;
    const std::vector<double> evidence = EvidenceOf(alignment, false);
    results.unknown.push_back({false, unit_.clip, label(), FindBestLabel(evidence, alignment),
                               LogDistance(evidence[label()], alignment)});
  }

  void AddUnknown(const WindowAlignment& others, TrialResults& results) const {
    results.unknown.push_back(
        {true, unit_.clip, label(), FindBestLabel(EvidenceOf(others, true), others), 0});
  }

  const Model& model_;
  const LabelUnits& units_;
  const LabelUnit unit_;
  const bool with_unknown_;
  std::shared_ptr<const ClipMask> mask_;  // null: no clip remains in the model
  // Also without clips that have only the label; null: none remains.
  std::shared_ptr<const ClipMask> mask_with_label_;
  std::vector<int> units_of_label_;  // that remain in the model
  std::size_t other_units_ = 0;      // that remain and do not have the label
  bool has_label_ = false;           // a remaining unit has the label
  bool try_unknown_ = false;         // a remaining unit has another label
};

// Fits the weight, the familiarity, and, if `with_unknown`, the probability of unknown motion.
// Without samples the weight keeps its default.
void Fit(const std::vector<std::string>& labels, TrialResults results,
         const std::vector<double>& powers, bool with_unknown, AnswerCalibration& calibration) {
  if (!results.samples.empty()) {
    calibration.weight = FitEvidenceWeight(results.samples, powers);
  }
  if (with_unknown) calibration.unknown = FitUnknownModel(labels, results.unknown);
  std::sort(results.familiarity.begin(), results.familiarity.end());
  calibration.familiarity = std::move(results.familiarity);
}

// Returns whether the clips suffice to hold out clips, labels and subjects.
UnknownCalibration CanCalibrateUnknown(const Model& model, std::size_t labels) {
  std::set<std::string> subjects;
  for (const ModelClip& clip : model.clips()) {
    if (!clip.subject.empty()) subjects.insert(clip.subject);
  }
  if (model.clips().size() < 2) return UnknownCalibration::kOneClip;
  if (labels < 2) return UnknownCalibration::kOneLabel;
  if (subjects.size() < 2) return UnknownCalibration::kOneSubject;
  return UnknownCalibration::kFitted;
}

}  // namespace

int ClipsTriedWhole(int clips, double frames, double max_frames) {
  const double length = frames / clips;
  const double comparisons_of_clip =
      std::min(length, max_frames) * length * std::min<double>(clips, kMaxShortlisted);
  const double within_limit = kMaxComparisons / comparisons_of_clip;
  return static_cast<int>(std::clamp<double>(within_limit, kMinWholeClips, kMaxWholeClips));
}

absl::StatusOr<RecognitionCalibration> CalibrateRecognition(const Model& model,
                                                            const ParallelFor& parallel,
                                                            const BuildProgress& progress) {
  RecognitionCalibration calibration;
  if (model.metric().empty()) return calibration;
  const std::vector<std::string>& labels = model.action_units()->labels();
  calibration.unknown = CanCalibrateUnknown(model, labels.size());
  const bool with_unknown = calibration.unknown == UnknownCalibration::kFitted;
  const std::vector<LabelUnit> units = SampleUnits(model, kMaxRecognizedUnits);
  const auto count = static_cast<int>(units.size());
  const int windows_per_unit = std::max(1, kMaxWindows / count);
  const double rate = model.settings().frame_rate_hz;
  const int full_width = std::max(1, static_cast<int>(std::lround(kWindowSeconds * rate)));
  const std::vector<int> whole_units =
      SpreadEvenly(count, ClipsTriedWhole(static_cast<int>(model.clips().size()),
                                          model.frame_count(), kMaxWholeSeconds * rate));
  std::vector<TrialResults> windows(units.size());
  std::vector<TrialResults> whole(units.size());
  const auto run_trial = [&](int i) {
    const HeldOutUnit held_out(model, units[i], with_unknown);
    const StateSequence motion = StoredMotion(model, units[i]);
    const int frames = motion.frame_count();
    const int width = std::min(frames, full_width);
    const auto distinct =
        static_cast<int>(std::ceil((frames - width + 1) / (kMinWindowDistance * rate)));
    windows[i] = held_out.Windows(
        model.states().middleRows(units[i].first_frame, frames),
        SpreadEvenly(frames - width + 1, std::min(windows_per_unit, distinct)), width);

    if (!std::binary_search(whole_units.begin(), whole_units.end(), i)) return;
    whole[i] = held_out.Beginnings(motion);
  };
  MOTIONDB_RETURN_IF_ERROR(
      RunTrials(count, "calibration of labels", parallel, progress, run_trial));
  for (int i = 1; i < count; ++i) {
    windows[0].Append(windows[i]);
    whole[0].Append(whole[i]);
  }
  Fit(labels, std::move(windows[0]), {1}, with_unknown, calibration.window);
  Fit(labels, std::move(whole[0]), {std::begin(kPowers), std::end(kPowers)}, with_unknown,
      calibration.whole);
  if (with_unknown && !(calibration.window.unknown && calibration.whole.unknown)) {
    calibration.unknown = UnknownCalibration::kTooFewClips;
    calibration.window.unknown.reset();
    calibration.whole.unknown.reset();
  }
  return calibration;
}

}  // namespace motiondb::core
