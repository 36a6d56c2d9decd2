// Counts the elements of an SVG file.
#pragma once

#include <tinyxml2.h>

#include <catch2/catch.hpp>
#include <map>
#include <string>

namespace motiondb::tests {

inline void CountElements(const tinyxml2::XMLElement* element, std::map<std::string, int>& counts) {
  for (; element != nullptr; element = element->NextSiblingElement()) {
    if (const char* name = element->Attribute("class")) {
      ++counts[std::string(element->Name()) + "." + name];
    }
    CountElements(element->FirstChildElement(), counts);
  }
}

// Returns the number of elements of each type and class in the groups of the file. Fails if it is
// not XML.
inline std::map<std::string, int> ElementsInGroups(const std::string& svg) {
  tinyxml2::XMLDocument document;
  REQUIRE(document.Parse(svg.c_str()) == tinyxml2::XML_SUCCESS);
  REQUIRE(std::string(document.RootElement()->Name()) == "svg");
  const auto* group = document.RootElement()->FirstChildElement("g");
  std::map<std::string, int> counts;
  for (; group != nullptr; group = group->NextSiblingElement("g")) {
    CountElements(group->FirstChildElement(), counts);
  }
  return counts;
}

}  // namespace motiondb::tests
