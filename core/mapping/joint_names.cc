#include "core/mapping/joint_names.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <span>
#include <unordered_map>
#include <unordered_set>

namespace motiondb::core {
namespace {

struct Meaning {
  Role role;
  float fit;
};

// Words, and words that follow each other ("upper leg"), without separators. Sources: the rigs,
// suits, body models and camera skeletons of docs/file_formats.md.
const std::unordered_map<std::string_view, std::vector<Meaning>>& Lexicon() {
  using enum Role;
  static const std::unordered_map<std::string_view, std::vector<Meaning>> lexicon = {
      {"pelvis", {{kPelvis, 1}}},
      {"hips", {{kPelvis, 1}}},
      {"midhip", {{kPelvis, 1}}},
      {"hipcenter", {{kPelvis, 1}}},
      {"spinebase", {{kPelvis, 1}}},
      {"hip", {{kPelvis, 0.8}, {kHip, 1}}},
      {"root", {{kPelvis, 0.4}}},

      {"spine", {{kSpine, 1}}},
      {"spinemid", {{kSpine, 1}}},
      {"spinenavel", {{kSpine, 1}}},
      {"spinechest", {{kSpine, 1}}},
      {"chest", {{kSpine, 1}}},
      {"abdomen", {{kSpine, 1}}},
      {"ab", {{kSpine, 1}}},
      {"torso", {{kSpine, 1}}},
      {"thorax", {{kSpine, 1}}},
      {"back", {{kSpine, 0.8}}},
      {"waist", {{kSpine, 0.8}}},
      {"lumbar", {{kSpine, 1}}},
      {"stomach", {{kSpine, 1}}},
      {"belly", {{kSpine, 1}}},
      {"rib", {{kSpine, 0.7}}},
      {"ribs", {{kSpine, 0.7}}},
      {"upperbody", {{kSpine, 1}}},
      {"body", {{kSpine, 0.4}}},

      {"neck", {{kNeck, 1}}},
      {"cervical", {{kNeck, 0.9}}},
      {"spineshoulder", {{kNeck, 1}}},
      {"shouldercenter", {{kNeck, 1}}},
      {"head", {{kHead, 1}}},
      {"skull", {{kHead, 1}}},
      {"headtop", {{kHeadTop, 1}}},
      {"headtip", {{kHeadTop, 1}}},
      {"crown", {{kHeadTop, 1}}},
      {"vertex", {{kHeadTop, 1}}},

      {"thigh", {{kHip, 1}}},
      {"upleg", {{kHip, 1}}},
      {"upperleg", {{kHip, 1}}},
      {"uleg", {{kHip, 1}}},
      {"femur", {{kHip, 1}}},
      {"hipjoint", {{kHip, 0.6}}},
      {"leg", {{kKnee, 0.7}, {kHip, 0.5}}},
      {"knee", {{kKnee, 1}}},
      {"lowleg", {{kKnee, 1}}},
      {"lowerleg", {{kKnee, 1}}},
      {"lleg", {{kKnee, 0.7}}},
      {"shin", {{kKnee, 1}}},
      {"shank", {{kKnee, 1}}},
      {"calf", {{kKnee, 1}}},
      {"tibia", {{kKnee, 1}}},
      {"crus", {{kKnee, 1}}},
      {"ankle", {{kAnkle, 1}}},
      {"foot", {{kAnkle, 0.9}, {kToe, 0.4}}},
      {"heel", {{kHeel, 1}}},
      {"calcaneus", {{kHeel, 1}}},
      {"toe", {{kToe, 1}}},
      {"toes", {{kToe, 1}}},
      {"toebase", {{kToe, 1}}},
      {"ball", {{kToe, 1}}},
      {"forefoot", {{kToe, 1}}},
      {"metatarsal", {{kToe, 1}}},
      {"metatarsals", {{kToe, 1}}},
      {"footindex", {{kToeTip, 0.8}, {kToe, 0.6}}},
      {"bigtoe", {{kToeTip, 0.8}, {kToe, 0.6}}},
      {"smalltoe", {{kToeTip, 0.4}}},

      {"clavicle", {{kClavicle, 1}}},
      {"collar", {{kClavicle, 1}}},
      {"collarbone", {{kClavicle, 1}}},
      {"scapula", {{kClavicle, 0.8}}},
      {"innershoulder", {{kClavicle, 1}}},
      {"shoulder", {{kClavicle, 0.7}, {kShoulder, 0.8}}},
      {"shldr", {{kShoulder, 1}}},
      {"arm", {{kShoulder, 0.8}, {kElbow, 0.3}}},
      {"upperarm", {{kShoulder, 1}}},
      {"uparm", {{kShoulder, 1}}},
      {"uarm", {{kShoulder, 1}}},
      {"humerus", {{kShoulder, 1}}},
      {"bicep", {{kShoulder, 0.8}}},
      {"elbow", {{kElbow, 1}}},
      {"forearm", {{kElbow, 1}}},
      {"forarm", {{kElbow, 1}}},
      {"lowerarm", {{kElbow, 1}}},
      {"lowarm", {{kElbow, 1}}},
      {"farm", {{kElbow, 1}}},
      {"radius", {{kElbow, 1}}},
      {"ulna", {{kElbow, 1}}},
      {"wrist", {{kWrist, 1}}},
      {"hand", {{kWrist, 0.9}, {kHand, 0.3}}},
      {"palm", {{kHand, 0.7}}},
      {"fingers", {{kHand, 0.9}}},
      {"knuckle", {{kHand, 1}}},
      {"knuckles", {{kHand, 1}}},
      {"handtip", {{kHand, 0.5}}},
      {"middle", {{kHand, 0.8}}},
      {"handmiddle", {{kHand, 0.8}}},

      // Joint centres of the conventional gait model.
      {"midhjc", {{kPelvis, 1}}},
      {"trxo", {{kNeck, 0.8}}},
      {"hedo", {{kHead, 1}}},
      {"hjc", {{kHip, 1}}},
      {"kjc", {{kKnee, 1}}},
      {"ajc", {{kAnkle, 1}}},
      {"sjc", {{kShoulder, 1}}},
      {"ejc", {{kElbow, 1}}},
      {"wjc", {{kWrist, 1}}},

      // The reference model of the KIT's MMM: body, left or right, segment, axis.
      {"bp", {{kPelvis, 0.8}}},
      {"bt", {{kSpine, 0.8}}},
      {"bln", {{kNeck, 0.8}}},
      {"bun", {{kHead, 0.8}}},
  };
  return lexicon;
}

// Codes of one letter after a side, in MMM: "LSx", "RK".
const std::unordered_map<char, Role> kSegmentCodes = {
    {'h', Role::kHip},      {'k', Role::kKnee},  {'a', Role::kAnkle}, {'f', Role::kToe},
    {'s', Role::kShoulder}, {'e', Role::kElbow}, {'w', Role::kWrist}};

// Words that only modify others; known, so that "lowerback" divides into words.
const std::unordered_set<std::string_view> kModifiers = {
    "up",  "upper", "low",     "lower",  "mid",   "center", "centre", "base",
    "top", "inner", "outer",   "joint",  "bend",  "fore",   "big",    "small",
    "in",  "bone",  "segment", "clavic", "front", "side",   "blade"};

const std::unordered_set<std::string_view> kEnds = {"end", "nub",  "site",   "tip",
                                                    "eff", "leaf", "endsite"};

const std::unordered_set<std::string_view> kAccessories = {
    "twist",      "roll",     "ik",     "fk",      "pole",    "helper",   "prop",   "weapon",
    "attach",     "socket",   "ctrl",   "control", "target",  "hair",     "skirt",  "breast",
    "bust",       "pectoral", "pec",    "butt",    "buttock", "glute",    "jaw",    "eye",
    "eyes",       "ear",      "nose",   "tongue",  "brow",    "lip",      "lips",   "cheek",
    "tail",       "cloth",    "dummy",  "camera",  "muscle",  "thumb",    "index",  "ring",
    "pinky",      "pinkie",   "little", "finger",  "face",    "facial",   "chin",   "mouth",
    "eyelid",     "teeth",    "cape",   "sword",   "gun",     "shield",   "share",  "correct",
    "metacarpal", "carpal",   "sec",    "offset",  "virtual", "genital",  "belt",   "pocket",
    "hat",        "glasses",  "mid1",   "pinky1",  "eyebrow", "forehead", "nipple", "anus"};

bool IsLeft(std::string_view word) { return word == "l" || word == "left" || word == "lft"; }
bool IsRight(std::string_view word) { return word == "r" || word == "right" || word == "rgt"; }

bool IsKnown(std::string_view word) {
  return Lexicon().contains(word) || kModifiers.contains(word) || kEnds.contains(word) ||
         kAccessories.contains(word) || word == "left" || word == "right";
}

// Divides a word without separators, such as "lfemur" or "leftupleg", into the fewest known words.
// A side of one letter stands at either end. Returns the word itself if it cannot be divided.
std::vector<std::string> Divide(const std::string& word) {
  if (word.size() < 3 || word.size() > 32 || IsKnown(word)) return {word};
  const int size = static_cast<int>(word.size());
  std::vector<int> begin_of(size + 1, -1);  // of the last word that ends here
  std::vector<int> count(size + 1, size + 1);
  count[0] = 0;
  for (int end = 1; end <= size; ++end) {
    for (int begin = end - 1; begin >= 0; --begin) {
      const std::string_view part = std::string_view(word).substr(begin, end - begin);
      const bool is_side =
          part.size() == 1 && (part == "l" || part == "r") && (begin == 0 || end == size);
      if (count[begin] + 1 >= count[end] || !(is_side || (part.size() > 1 && IsKnown(part)))) {
        continue;
      }
      count[end] = count[begin] + 1;
      begin_of[end] = begin;
    }
  }
  if (begin_of[size] < 0) return {word};
  std::vector<std::string> words;
  for (int end = size; end > 0; end = begin_of[end]) {
    words.insert(words.begin(), word.substr(begin_of[end], end - begin_of[end]));
  }
  return words;
}

bool IsUpper(char c) { return c >= 'A' && c <= 'Z'; }
bool IsLower(char c) { return c >= 'a' && c <= 'z'; }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }

char Lower(char c) { return IsUpper(c) ? static_cast<char>(c - 'A' + 'a') : c; }

// Splits at separators, between letters and digits, and at capital letters. Two capitals directly
// before a word are letters of their own: "LUArm" is left, upper, arm.
std::vector<std::string> SplitName(std::string_view name) {
  std::vector<std::string> words;
  std::string word;
  bool is_capitals = false;  // `word` has capitals only
  const auto flush = [&](bool precedes_word) {
    if (precedes_word && is_capitals && word.size() == 2) {
      words.emplace_back(1, word[0]);
      word.erase(0, 1);
    }
    if (!word.empty()) words.push_back(std::move(word));
    word.clear();
    is_capitals = true;
  };
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (!IsUpper(c) && !IsLower(c) && !IsDigit(c)) {
      flush(false);
      continue;
    }
    const char before = i > 0 ? name[i - 1] : '_';
    const char after = i + 1 < name.size() ? name[i + 1] : '_';
    const bool begins_word = IsUpper(c) && (IsLower(before) || (IsUpper(before) && IsLower(after)));
    if (word.empty() || begins_word || IsDigit(c) != IsDigit(before)) flush(begins_word);
    word += Lower(c);
    is_capitals = is_capitals && IsUpper(c);
  }
  flush(false);
  return words;
}

// A vertebra: "L5", "T12", "C7".
bool IsVertebra(std::string_view name) {
  return (name.size() == 2 || name.size() == 3) && (name[0] == 'L' || name[0] == 'T') &&
         std::ranges::all_of(name.substr(1), IsDigit);
}

NameMeaning MeaningOf(std::span<const std::string> words) {
  NameMeaning meaning;
  bool left = false;
  bool right = false;
  bool is_end = false;
  std::vector<std::string_view> rest;
  for (const std::string& word : words) {
    left = left || IsLeft(word);
    right = right || IsRight(word);
    is_end = is_end || kEnds.contains(word);
    if (!IsLeft(word) && !IsRight(word) && !kEnds.contains(word) && !IsDigit(word[0])) {
      rest.push_back(word);
    }
  }
  if (left != right) meaning.side = left ? Side::kLeft : Side::kRight;
  // The longest phrase counts.
  std::size_t longest = 0;
  std::size_t phrase_begin = 0;
  const auto set = [&](Role role, float fit) { meaning.fit[static_cast<std::size_t>(role)] = fit; };
  for (std::size_t begin = 0; begin < rest.size(); ++begin) {
    std::string phrase;
    for (std::size_t end = begin; end < rest.size(); ++end) {
      phrase += rest[end];
      const auto found = Lexicon().find(phrase);
      if (found == Lexicon().end() || end + 1 - begin < longest) continue;
      if (end + 1 - begin > longest) meaning.fit.fill(0);
      longest = end + 1 - begin;
      phrase_begin = begin;
      for (const auto& [role, fit] : found->second) set(role, fit);
    }
  }
  std::vector<std::string_view> others;  // words outside the phrase
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (i >= phrase_begin && i < phrase_begin + longest) continue;
    meaning.is_accessory = meaning.is_accessory || kAccessories.contains(rest[i]);
    if (!kModifiers.contains(rest[i])) others.push_back(rest[i]);
  }
  if (longest == 0 && meaning.side != Side::kNone && others.size() == 1 && others[0].size() <= 2 &&
      (others[0].size() == 1 || (others[0][1] >= 'x' && others[0][1] <= 'z'))) {
    const auto code = kSegmentCodes.find(others[0][0]);
    if (code != kSegmentCodes.end()) set(code->second, 0.6F);
  }
  const auto fit = [&](Role role) { return meaning.fit_for(role); };
  // Hips have sides, the pelvis has none.
  if (meaning.side == Side::kNone) {
    set(Role::kHip, 0);
  } else {
    set(Role::kPelvis, 0);
  }
  if (is_end) {
    const float head = std::max(fit(Role::kHead), fit(Role::kHeadTop));
    const float toe = std::max(fit(Role::kToe), fit(Role::kAnkle));
    const float hand = fit(Role::kWrist);
    meaning.fit.fill(0);
    set(Role::kHeadTop, head);
    set(Role::kToeTip, toe);
    set(Role::kHand, 0.5F * hand);
  }
  if (meaning.is_accessory) {
    meaning.fit.fill(0);
    if (rest.size() == 1 && rest[0] == "nose") set(Role::kNose, 1);
    if (rest.size() == 1 && rest[0] == "eye") set(Role::kEye, 1);
    if (rest.size() == 1 && rest[0] == "ear") set(Role::kEar, 1);
  }
  return meaning;
}

// Decides ambiguous names of one side by the others: a "shoulder" is the clavicle if there is an
// "arm", a "leg" is the shank if there is a "thigh", and the thigh if there is a "shin".
void ResolveSide(Side side, std::vector<NameMeaning>& meanings) {
  const auto index = [](Role role) { return static_cast<std::size_t>(role); };
  const auto has = [&](Role role, float least, Role not_role) {
    return std::ranges::any_of(meanings, [&](const NameMeaning& meaning) {
      return meaning.side == side && meaning.fit_for(role) >= least &&
             meaning.fit_for(not_role) == 0;
    });
  };
  // Names that fit both roles fit only `right` if another name certainly has the role `wrong`.
  const auto decide = [&](Role wrong, Role right) {
    for (NameMeaning& meaning : meanings) {
      if (meaning.side != side || meaning.fit_for(wrong) == 0 || meaning.fit_for(right) == 0) {
        continue;
      }
      meaning.fit[index(wrong)] = 0.1F;
      meaning.fit[index(right)] = 1;
    }
  };
  if (has(Role::kShoulder, 0.8F, Role::kClavicle)) decide(Role::kShoulder, Role::kClavicle);
  if (has(Role::kHip, 1, Role::kKnee)) {
    decide(Role::kHip, Role::kKnee);
  } else if (has(Role::kKnee, 1, Role::kHip)) {
    decide(Role::kKnee, Role::kHip);
  }
  if (has(Role::kAnkle, 1, Role::kToe)) decide(Role::kAnkle, Role::kToe);
  if (has(Role::kWrist, 1, Role::kHand)) decide(Role::kWrist, Role::kHand);
}

}  // namespace

std::vector<std::string> NameWords(std::string_view name) {
  if (const auto at = name.find_last_of(":|"); at != name.npos && at + 1 < name.size()) {
    name.remove_prefix(at + 1);
  }
  if (IsVertebra(name)) return {"spine"};
  std::vector<std::string> words;
  for (const std::string& part : SplitName(name)) {
    std::ranges::move(Divide(part), std::back_inserter(words));
  }
  return words;
}

std::vector<std::vector<std::string>> WordsWithoutPrefix(const std::vector<std::string>& names) {
  std::vector<std::vector<std::string>> words;
  std::map<std::string, std::size_t> first_words;
  words.reserve(names.size());
  for (const std::string& name : names) words.push_back(NameWords(name));
  // Removes the words that most names begin with, one after another.
  while (names.size() >= 4) {
    first_words.clear();
    for (const auto& of_name : words) {
      const bool is_side = IsLeft(of_name.empty() ? "" : of_name.front()) ||
                           IsRight(of_name.empty() ? "" : of_name.front());
      if (of_name.size() > 1 && !is_side) ++first_words[of_name.front()];
    }
    const auto most =
        std::ranges::max_element(first_words, {}, [](const auto& entry) { return entry.second; });
    if (most == first_words.end() || 5 * most->second < 4 * names.size()) break;
    const std::string prefix = most->first;
    for (auto& of_name : words) {
      if (of_name.size() > 1 && of_name.front() == prefix) of_name.erase(of_name.begin());
    }
  }
  return words;
}

std::vector<NameMeaning> NameMeanings(const std::vector<std::string>& names) {
  std::vector<NameMeaning> meanings;
  meanings.reserve(names.size());
  for (const auto& of_name : WordsWithoutPrefix(names)) meanings.push_back(MeaningOf(of_name));
  ResolveSide(Side::kLeft, meanings);
  ResolveSide(Side::kRight, meanings);
  return meanings;
}

}  // namespace motiondb::core
