#include "client/cli/annotate/batch_edit.h"

#include <fmt/format.h>
#include <motiondb/v1/operation.pb.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "absl/strings/numbers.h"
#include "client/call_failure.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"

namespace motiondb::client {
namespace {

constexpr std::string_view kChangePrefix = "changes[";

// "create_segment.segment.label" -> "label"; empty if only the change is named.
std::string LastField(std::string_view path) {
  const std::string_view last = path.substr(path.rfind('.') + 1);
  const bool is_change = last.ends_with("_segment") || last == "update_clip";
  return std::string(is_change ? std::string_view() : last);
}

// Whether a change, not the server or the caller, is the reason of an error.
bool ConcernsChange(const absl::Status& status) {
  return absl::IsInvalidArgument(status) || absl::IsNotFound(status) ||
         absl::IsAlreadyExists(status) || absl::IsFailedPrecondition(status) ||
         absl::IsAborted(status);
}

}  // namespace

std::optional<FailedChange> FailedChangeOf(const absl::Status& status) {
  std::string_view text(status.message().data(), status.message().size());
  const std::size_t begin = text.find(kChangePrefix);
  if (begin == std::string_view::npos) return std::nullopt;
  text.remove_prefix(begin + kChangePrefix.size());
  FailedChange failed;
  const std::size_t bracket = text.find(']');
  if (!absl::SimpleAtoi(std::string(text.substr(0, bracket)), &failed.index)) return std::nullopt;
  text.remove_prefix(bracket + 1);
  const std::size_t end = std::min(text.find_first_of(": "), text.size());
  const std::string field = LastField(text.substr(0, end));
  text.remove_prefix(end);
  text.remove_prefix(std::min(text.find_first_not_of(": "), text.size()));
  failed.detail = (field.empty() ? "" : field + ": ") + std::string(text);
  return failed;
}

std::int64_t SentChanges::revision() const {
  return responses.empty() ? 0 : responses.back().revision();
}

std::string SentChanges::operation() const {
  for (auto response = responses.rbegin(); response != responses.rend(); ++response) {
    if (!response->operation().name().empty()) return response->operation().name();
  }
  return "";
}

absl::StatusOr<v1::BatchEditResponse> SendBatch(
    const Client& client, const std::string& database, std::span<const v1::Change> changes,
    const std::function<std::string(std::size_t)>& place_of) {
  v1::BatchEditRequest request;
  request.set_parent(database);
  for (const v1::Change& change : changes) *request.add_changes() = change;
  auto response = client.BatchEdit(request);
  if (response.ok()) return response;
  auto failed = FailedChangeOf(response.status());
  // The error of a single change has no index.
  if (!failed && changes.size() == 1 && ConcernsChange(response.status())) {
    failed = FailedChange{0, std::string(response.status().message())};
  }
  if (!failed || failed->index >= changes.size()) return response;
  return WithMessage(response.status(),
                     fmt::format("{}: {}", place_of(failed->index), failed->detail));
}

absl::Status SendChanges(const Client& client, const std::string& database,
                         const std::vector<v1::Change>& changes,
                         const std::function<std::string(std::size_t)>& place_of,
                         SentChanges& sent) {
  ProgressBar bar;
  const std::span<const v1::Change> all(changes);
  for (std::size_t begin = 0; begin < all.size(); begin += kMaxBatchChanges) {
    if (all.size() > kMaxBatchChanges) {
      bar.Show(static_cast<double>(begin) / static_cast<double>(all.size()),
               fmt::format("{} of {} changes", begin, all.size()));
    }
    const auto batch = all.subspan(begin, std::min(kMaxBatchChanges, all.size() - begin));
    auto response =
        SendBatch(client, database, batch, [&](std::size_t i) { return place_of(begin + i); });
    if (!response.ok()) {
      bar.Clear();
      return WithMessage(
          response.status(),
          fmt::format("{}; {} of {} stored", std::string(response.status().message()), sent.stored,
                      CountText(static_cast<std::int64_t>(all.size()), "change")));
    }
    sent.stored = begin + batch.size();
    sent.responses.push_back(*std::move(response));
  }
  return absl::OkStatus();
}

absl::Status WaitForModel(const Client& client, const std::string& operation,
                          const std::string& done) {
  if (operation.empty()) return absl::OkStatus();
  return WaitForRebuild(client, operation, done).status();
}

}  // namespace motiondb::client
