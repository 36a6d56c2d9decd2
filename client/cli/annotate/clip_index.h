// Finds clips by the names that files of annotations use.
#pragma once

#include <motiondb/v1/clip.pb.h>

#include <map>
#include <set>
#include <string>
#include <vector>

namespace motiondb::client {

// The clips of a database, found by their name or by the name of their file.
class ClipIndex {
 public:
  explicit ClipIndex(const std::vector<v1::Clip>& clips);

  // Returns the clip that an annotation names: its id or, without folders and extension, the only
  // clip with this id or file name. Null: there is none, or several have this file name.
  const v1::Clip* Find(const std::string& name) const;

  // Returns a name of the clip's motion file by which Find returns the clip.
  std::string FileNameOf(const v1::Clip& clip) const;

  std::vector<std::string> Names() const;

 private:
  std::map<std::string, v1::Clip> clips_;     // by id
  std::map<std::string, std::string> id_of_;  // by file name without extension
  std::set<std::string> ambiguous_;           // such file names of several clips
};

}  // namespace motiondb::client
