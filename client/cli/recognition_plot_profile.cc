#include "client/cli/recognition_plot_profile.h"

#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

bool MakesSense(const v1::RecognitionWindow& window) {
  constexpr double kLongestSeconds = 1e8;
  return window.start_seconds() >= 0 && window.start_seconds() <= window.end_seconds() &&
         window.end_seconds() <= kLongestSeconds;
}

std::vector<WindowCell> Cells(const std::vector<const v1::RecognitionWindow*>& windows) {
  std::vector<WindowCell> cells;
  for (const v1::RecognitionWindow* window : windows) {
    cells.push_back({window->start_seconds(), (window->start_seconds() + window->end_seconds()) / 2,
                     window->end_seconds()});
  }
  const std::size_t count = cells.size();
  for (std::size_t i = 0; i + 1 < count; ++i) {
    cells[i].end = cells[i + 1].start = (cells[i].middle + cells[i + 1].middle) / 2;
  }
  if (count > 1) {  // the ends are as wide to both sides; a window alone stands for all of itself
    cells.front().start = 2 * cells.front().middle - cells.front().end;
    cells.back().end = 2 * cells.back().middle - cells.back().start;
  }
  return cells;
}

}  // namespace

LayerProfile ProfileOf(const v1::RecognizeResponse& response) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::vector<const v1::RecognitionWindow*> windows;
  for (const v1::RecognitionWindow& window : response.windows()) {
    if (MakesSense(window)) windows.push_back(&window);
  }
  LayerProfile profile;
  if (windows.empty()) return profile;
  profile.layer = windows.front()->layer();
  profile.window_seconds = windows.front()->end_seconds() - windows.front()->start_seconds();
  profile.windows = Cells(windows);
  std::map<std::string, ClipProfile> clips;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    bool explained = false;
    for (const v1::ClipProbability& clip : windows[i]->clips()) {
      ClipProfile& drawn = clips[clip.clip()];
      if (drawn.log_probability.empty()) {
        drawn.clip = ShortName(clip.clip());
        drawn.label = LabelWord(clip.label());
        drawn.log_probability.assign(windows.size(), kNone);
      }
      if (!std::isfinite(clip.log_probability())) continue;
      drawn.log_probability[i] = clip.log_probability();
      explained = true;
    }
    // Where no clip fits, all labels are alike, and none of them wins.
    profile.winners.emplace_back();
    if (explained && windows[i]->labels_size() > 0) {
      profile.winners.back() = LabelWord(windows[i]->labels(0).label());
    }
  }
  for (auto& [name, clip] : clips) profile.clips.push_back(std::move(clip));
  return profile;
}

}  // namespace motiondb::client
