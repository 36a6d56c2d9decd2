// Whole lists: one call a page until the server gives no further token.
#include <fmt/format.h>

#include <utility>

#include "client/connection.h"

namespace motiondb::client {
namespace {

// `fetch` makes one call; `items` is the accessor of a page's repeated field.
template <typename Item, typename Request, typename Fetch, typename Items>
absl::StatusOr<std::vector<Item>> AllPages(Request request, const Fetch& fetch,
                                           const Items& items) {
  if (!request.page_token().empty()) {
    return absl::InvalidArgumentError("page_token must be empty to read a whole list");
  }
  std::vector<Item> all;
  while (true) {
    auto page = fetch(request);
    if (!page.ok()) return page.status();
    for (Item& item : *items(*page)) all.push_back(std::move(item));
    // A token that does not move on would never end.
    if (!page->next_page_token().empty() && page->next_page_token() == request.page_token()) {
      return absl::InternalError(
          fmt::format("the server gave the page token \"{}\" twice", request.page_token()));
    }
    request.set_page_token(page->next_page_token());
    if (request.page_token().empty()) return all;
  }
}

}  // namespace

absl::StatusOr<std::vector<v1::Database>> Client::AllDatabases(CallOptions options) const {
  return AllPages<v1::Database>(
      v1::ListDatabasesRequest(), [&](const auto& page) { return ListDatabases(page, options); },
      [](auto& page) { return page.mutable_databases(); });
}

absl::StatusOr<std::vector<v1::Token>> Client::AllTokens(CallOptions options) const {
  return AllPages<v1::Token>(
      v1::ListTokensRequest(), [&](const auto& page) { return ListTokens(page, options); },
      [](auto& page) { return page.mutable_tokens(); });
}

absl::StatusOr<std::vector<v1::Clip>> Client::AllClips(const v1::ListClipsRequest& request,
                                                       CallOptions options) const {
  return AllPages<v1::Clip>(
      request, [&](const auto& page) { return ListClips(page, options); },
      [](auto& page) { return page.mutable_clips(); });
}

absl::StatusOr<std::vector<v1::Skeleton>> Client::AllSkeletons(
    const v1::ListSkeletonsRequest& request, CallOptions options) const {
  return AllPages<v1::Skeleton>(
      request, [&](const auto& page) { return ListSkeletons(page, options); },
      [](auto& page) { return page.mutable_skeletons(); });
}

absl::StatusOr<std::vector<v1::Model>> Client::AllModels(const v1::ListModelsRequest& request,
                                                         CallOptions options) const {
  return AllPages<v1::Model>(
      request, [&](const auto& page) { return ListModels(page, options); },
      [](auto& page) { return page.mutable_models(); });
}

absl::StatusOr<std::vector<v1::Node>> Client::AllNodes(const v1::ListNodesRequest& request,
                                                       CallOptions options) const {
  return AllPages<v1::Node>(
      request, [&](const auto& page) { return ListNodes(page, options); },
      [](auto& page) { return page.mutable_nodes(); });
}

absl::StatusOr<std::vector<v1::Transition>> Client::AllTransitions(
    const v1::ListTransitionsRequest& request, CallOptions options) const {
  return AllPages<v1::Transition>(
      request, [&](const auto& page) { return ListTransitions(page, options); },
      [](auto& page) { return page.mutable_transitions(); });
}

absl::StatusOr<std::vector<v1::Operation>> Client::AllOperations(
    const v1::ListOperationsRequest& request, CallOptions options) const {
  return AllPages<v1::Operation>(
      request, [&](const auto& page) { return ListOperations(page, options); },
      [](auto& page) { return page.mutable_operations(); });
}

}  // namespace motiondb::client
