#include "storage/text_query.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/motion/error.h"

namespace motiondb::storage {
namespace {

// clang-format off
// Pairs of a letter and what it is normalised to, ascending: Latin letters without accent, and
// Latin, Greek and Cyrillic capitals in lower case. All have a code point below 0x10000.
constexpr std::u16string_view kFolds =
    u"ÀaÁaÂaÃaÄaÅaÆæÇcÈeÉeÊeËeÌiÍiÎiÏiÐðÑnÒoÓoÔoÕoÖoØøÙuÚuÛuÜuÝyÞþàaáaâaãaäaåaçcèeéeêeëeìiíiîi"
    u"ïiñnòoóoôoõoöoùuúuûuüuýyÿyĀaāaĂaăaĄaąaĆcćcĈcĉcĊcċcČcčcĎdďdĐđĒeēeĔeĕeĖeėeĘeęeĚeěeĜgĝgĞgğg"
    u"ĠgġgĢgģgĤhĥhĦħĨiĩiĪiīiĬiĭiĮiįiİiĲĳĴjĵjĶkķkĹlĺlĻlļlĽlľlĿŀŁłŃnńnŅnņnŇnňnŊŋŌoōoŎoŏoŐoőoŒœŔr"
    u"ŕrŖrŗrŘrřrŚsśsŜsŝsŞsşsŠsšsŢtţtŤtťtŦŧŨuũuŪuūuŬuŭuŮuůuŰuűuŲuųuŴwŵwŶyŷyŸyŹzźzŻzżzŽzžzƁɓƂƃƄƅ"
    u"ƆɔƇƈƉɖƊɗƋƌƎǝƏəƐɛƑƒƓɠƔɣƖɩƗɨƘƙƜɯƝɲƟɵƠoơoƢƣƤƥƦʀƧƨƩʃƬƭƮʈƯuưuƱʊƲʋƳƴƵƶƷʒƸƹƼƽǄǆǅǆǇǉǈǉǊǌǋǌǍaǎaǏi"
    u"ǐiǑoǒoǓuǔuǕuǖuǗuǘuǙuǚuǛuǜuǞaǟaǠaǡaǢǣǤǥǦgǧgǨkǩkǪoǫoǬoǭoǮǯǰjǱǳǲǳǴgǵgǶƕǷƿǸnǹnǺaǻaǼǽǾǿȀaȁaȂa"
    u"ȃaȄeȅeȆeȇeȈiȉiȊiȋiȌoȍoȎoȏoȐrȑrȒrȓrȔuȕuȖuȗuȘsșsȚtțtȜȝȞhȟhȠƞȢȣȤȥȦaȧaȨeȩeȪoȫoȬoȭoȮoȯoȰoȱoȲy"
    u"ȳyȺⱥȻȼȽƚȾⱦɁɂɃƀɄʉɅʌɆɇɈɉɊɋɌɍɎɏΆάΈέΉήΊίΌόΎύΏώΑαΒβΓγΔδΕεΖζΗηΘθΙιΚκΛλΜμΝνΞξΟοΠπΡρΣσΤτΥυΦφΧχΨψ"
    u"ΩωΪϊΫϋϏϗЀѐЁёЂђЃѓЄєЅѕІіЇїЈјЉљЊњЋћЌќЍѝЎўЏџАаБбВвГгДдЕеЖжЗзИиЙйКкЛлМмНнОоПпРрСсТтУуФфХхЦцЧч"
    u"ШшЩщЪъЫыЬьЭэЮюЯяѠѡѢѣѤѥѦѧѨѩѪѫѬѭѮѯѰѱѲѳѴѵѶѷѸѹѺѻѼѽѾѿҀҁҊҋҌҍҎҏҐґҒғҔҕҖҗҘҙҚқҜҝҞҟҠҡҢңҤҥҦҧҨҩҪҫҬҭҮү"
    u"ҰұҲҳҴҵҶҷҸҹҺһҼҽҾҿӀӏӁӂӃӄӅӆӇӈӉӊӋӌӍӎӐӑӒӓӔӕӖӗӘәӚӛӜӝӞӟӠӡӢӣӤӥӦӧӨөӪӫӬӭӮӯӰӱӲӳӴӵӶӷӸӹӺӻӼӽӾӿԀԁԂԃԄԅԆԇ"
    u"ԈԉԊԋԌԍԎԏԐԑԒԓԔԕԖԗԘԙԚԛԜԝԞԟԠԡԢԣԤԥԦԧԨԩԪԫԬԭԮԯḀaḁaḂbḃbḄbḅbḆbḇbḈcḉcḊdḋdḌdḍdḎdḏdḐdḑdḒdḓdḔeḕe"
    u"Ḗ"
    u"eḗe"
    u"ḘeḙeḚeḛeḜeḝeḞfḟfḠgḡgḢhḣhḤhḥhḦhḧhḨhḩhḪhḫhḬiḭiḮiḯiḰkḱkḲkḳkḴkḵkḶlḷlḸlḹlḺlḻlḼlḽlḾmḿmṀmṁmṂmṃm"
    u"ṄnṅnṆnṇnṈnṉnṊnṋnṌoṍoṎoṏoṐoṑoṒoṓoṔpṕpṖpṗpṘrṙrṚrṛrṜrṝrṞrṟrṠsṡsṢsṣsṤsṥsṦsṧsṨsṩsṪtṫtṬtṭtṮtṯt"
    u"ṰtṱtṲuṳuṴuṵuṶuṷuṸuṹuṺuṻuṼvṽvṾvṿvẀwẁwẂwẃwẄwẅwẆwẇwẈwẉwẊxẋxẌxẍxẎyẏyẐzẑzẒzẓzẔzẕzẖhẗtẘwẙyẞßẠa"
    u"ạaẢaảaẤaấaẦaầaẨaẩaẪaẫaẬaậaẮaắaẰaằaẲaẳaẴaẵaẶaặaẸeẹeẺeẻeẼeẽeẾeếeỀeềeỂeểeỄeễeỆeệeỈiỉiỊiịiỌo"
    u"ọoỎoỏoỐoốoỒoồoỔoổoỖoỗoỘoộoỚoớoỜoờoỞoởoỠoỡoỢoợoỤuụuỦuủuỨuứuỪuừuỬuửuỮuữuỰuựuỲyỳyỴyỵyỶyỷyỸy"
    u"ỹyỺỻỼỽỾỿ";
// clang-format on

constexpr char32_t kInvalid = 0;

// Reads the next character; kInvalid if the bytes are not UTF-8.
char32_t NextCharacter(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t first = byte(0);
  const std::size_t size = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  char32_t character = size == 1 ? first : first & (0x7f >> size);
  bool is_valid = first < 0x80 || (first >= 0xc2 && first < 0xf5 && text.size() >= size);
  for (std::size_t i = 1; is_valid && i < size; ++i) {
    is_valid = (byte(i) & 0xc0) == 0x80;
    character = character << 6 | (byte(i) & 0x3f);
  }
  text.remove_prefix(is_valid ? size : 1);
  return is_valid ? character : kInvalid;
}

void Append(char32_t c, std::string& text) {
  if (c < 0x80) {
    text += static_cast<char>(c);
    return;
  }
  const int rest = c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;  // bytes after the first
  constexpr std::array<unsigned, 4> kMarks = {0, 0xc0, 0xe0, 0xf0};
  text += static_cast<char>(kMarks[static_cast<std::size_t>(rest)] | (c >> (6 * rest)));
  for (int i = rest - 1; i >= 0; --i) text += static_cast<char>(0x80 | (c >> (6 * i) & 0x3f));
}

struct CharacterRange {
  char32_t first, last;
};

// Marks that are written over the letter before.
bool IsAccent(char32_t c) { return c >= 0x300 && c <= 0x36f; }

// Characters outside of ASCII that are neither letters nor digits, in the blocks in common use.
bool IsSeparator(char32_t c) {
  if (c < 0x80)
    return !((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'));
  if (c == 0xaa || c == 0xb5 || c == 0xba) return false;  // letters among the signs
  constexpr CharacterRange kSeparators[] = {
      {0x80, 0xbf},     {0xd7, 0xd7},     {0xf7, 0xf7},     {0x2000, 0x2bff}, {0x3000, 0x303f},
      {0xd800, 0xf8ff}, {0xfe00, 0xfe6f}, {0xfeff, 0xff0f}, {0xff1a, 0xff20}, {0xfff0, 0xffff}};
  return std::ranges::any_of(
      kSeparators, [c](const auto& range) { return c >= range.first && c <= range.last; });
}

char32_t Fold(char32_t c) {
  if (c < 0x80) return c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c;
  std::size_t first = 0;
  std::size_t end = kFolds.size() / 2;
  while (first < end) {
    const std::size_t middle = (first + end) / 2;
    const char32_t letter = kFolds[2 * middle];
    if (letter == c) return kFolds[2 * middle + 1];
    if (letter < c) {
      first = middle + 1;
    } else {
      end = middle;
    }
  }
  return c;
}

std::string JoinItems(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) {
    const std::string words = NormalizeText(item);
    if (words.empty()) continue;
    if (!text.empty()) text += fmt::format(" {} ", kItemSeparator);
    text += words;
  }
  return text;
}

bool Occurs(const TextTerm& term, std::string_view field) {
  std::vector<std::string_view> words;
  while (!field.empty()) {
    const std::size_t size = std::min(field.find(' '), field.size());
    words.push_back(field.substr(0, size));
    field.remove_prefix(std::min(size + 1, field.size()));
  }
  const auto is_last = [&](const std::string& word) { return &word == &term.words.back(); };
  const auto same = [&](std::string_view in_field, const std::string& in_term) {
    return term.is_prefix && is_last(in_term) ? in_field.starts_with(in_term) : in_field == in_term;
  };
  return std::search(words.begin(), words.end(), term.words.begin(), term.words.end(), same) !=
         words.end();
}

}  // namespace

std::vector<std::string> SearchWords(std::string_view text) {
  std::vector<std::string> words(1);
  while (!text.empty()) {
    const char32_t c = NextCharacter(text);
    if (IsAccent(c)) continue;
    if (!IsSeparator(c)) {
      Append(Fold(c), words.back());
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

std::string NormalizeText(std::string_view text) {
  std::string joined;
  for (const std::string& word : SearchWords(text)) {
    if (!joined.empty()) joined += ' ';
    joined += word;
  }
  return joined;
}

absl::StatusOr<std::vector<TextTerm>> ParseTextQuery(std::string_view query) {
  constexpr std::string_view kSpaces = " \t\r\n";
  const auto error = [](std::size_t place, std::string_view message) {
    return core::FieldViolation("query", "position {}: {}", place + 1, message);
  };
  std::vector<TextTerm> terms;
  std::size_t place = 0;
  while ((place = query.find_first_not_of(kSpaces, place)) != std::string_view::npos) {
    const bool is_phrase = query[place] == '"';
    const std::size_t first = place + (is_phrase ? 1 : 0);
    std::size_t end = query.find_first_of(is_phrase ? "\"" : " \t\r\n\"*", first);
    if (is_phrase && end == std::string_view::npos) {
      return error(place, "expected a second '\"' at the end of the phrase");
    }
    end = std::min(end, query.size());
    TextTerm& term = terms.emplace_back();
    term.words = SearchWords(query.substr(first, end - first));
    if (term.words.empty()) {
      return error(place, is_phrase ? "expected a word in the phrase"
                                    : "expected a letter or a digit in the word");
    }
    if (is_phrase) ++end;
    if (!is_phrase && end < query.size() && query[end] == '*') {
      term.is_prefix = true;
      ++end;
    }
    if (end < query.size() && kSpaces.find(query[end]) == std::string_view::npos) {
      return error(end, "expected a space");
    }
    place = end;
  }
  if (terms.empty()) return error(0, "expected a word");
  return terms;
}

ClipText TextOf(const ClipRecord& clip, std::span<const SegmentRecord> segments) {
  std::vector<std::string> labels;
  for (const SegmentRecord& segment : segments) labels.push_back(segment.label);
  std::ranges::sort(labels);
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  return {NormalizeText(clip.title),   NormalizeText(clip.description),
          JoinItems(clip.tags),        JoinItems(labels),
          NormalizeText(clip.subject), NormalizeText(clip.file_name)};
}

bool Matches(const ClipText& text, std::span<const TextTerm> terms) {
  return std::ranges::all_of(terms, [&](const TextTerm& term) {
    return std::ranges::any_of(text, [&](const auto& field) { return Occurs(term, field); });
  });
}

}  // namespace motiondb::storage
