#include "storage/store_url.h"

#include <algorithm>
#include <cstddef>

namespace motiondb::storage {
namespace {

constexpr std::string_view kHidden = "***";

// Hides the values of parameters whose name ends with "password".
std::string HideParameters(std::string_view query) {
  std::string hidden;
  while (true) {
    const std::size_t size = std::min(query.find('&'), query.size());
    const std::string_view parameter = query.substr(0, size);
    const std::size_t equals = parameter.find('=');
    const std::string_view name = parameter.substr(0, equals);
    if (name.ends_with("password") && equals != std::string_view::npos) {
      hidden += parameter.substr(0, equals + 1);
      hidden += kHidden;
    } else {
      hidden += parameter;
    }
    if (size == query.size()) return hidden;
    hidden += '&';
    query.remove_prefix(size + 1);
  }
}

}  // namespace

bool IsPostgresUrl(std::string_view store) {
  return store.starts_with("postgresql://") || store.starts_with("postgres://");
}

std::string WithoutPassword(std::string_view store) {
  if (!IsPostgresUrl(store)) return std::string(store);
  const std::size_t begin = store.find("://") + 3;
  const std::size_t question = std::min(store.find('?', begin), store.size());
  // A password may contain any character but these: the user ends at the last `@`.
  const std::size_t at = store.substr(0, question).rfind('@');
  const std::size_t colon = store.find(':', begin);
  std::string hidden;
  if (at != std::string_view::npos && colon < at) {
    hidden += store.substr(0, colon + 1);
    hidden += kHidden;
    hidden += store.substr(at, question - at);
  } else {
    hidden += store.substr(0, question);
  }
  if (question == store.size()) return hidden;
  return hidden + "?" + HideParameters(store.substr(question + 1));
}

}  // namespace motiondb::storage
