// Colours of clips in a map.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "client/cli/picture/state_map.h"
#include "client/cli/plot/picture.h"

namespace motiondb::client {

enum class MapColouring { kByLabel, kByClip };

// Gives labels or clips their colours, those of the plots of a recognition. Of more than 8, those
// with most frames have colours, and the others are grey.
class MapColours {
 public:
  MapColours(const StateMap& map, MapColouring colouring);

  // Style names of a clip, by name: for points and areas, and for lines. Unknown clips are grey.
  std::string FillStyle(const std::string& clip) const;
  std::string LineStyle(const std::string& clip) const;

  // Adds the styles of both.
  static void AddStyles(Canvas& canvas);

  std::vector<LegendEntry> Legend() const;

 private:
  std::map<std::string, int> place_of_clip_;
  std::vector<std::string> names_;
  int other_count_ = 0;
  const char* kind_;
};

}  // namespace motiondb::client
