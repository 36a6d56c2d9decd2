// Sends many changes of clips and segments in transactions.
#pragma once

#include <motiondb/client.h>
#include <motiondb/v1/edit.pb.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

// Maximum number of changes of a transaction in the wire contract.
inline constexpr std::size_t kMaxBatchChanges = 1000;

// Index and field of the change that the error of BatchEdit names, "changes[3].create_segment...".
struct FailedChange {
  std::size_t index = 0;
  std::string detail;  // message after the name of the change, with the wrong field: "label: ..."
};
std::optional<FailedChange> FailedChangeOf(const absl::Status& status);

// The transactions that were stored.
struct SentChanges {
  std::vector<v1::BatchEditResponse> responses;
  std::size_t stored = 0;  // number of changes

  // Revision after the last change; 0 if there is none.
  std::int64_t revision() const;
  // Last operation that fits the model; empty if there is none.
  std::string operation() const;
};

// Sends at most kMaxBatchChanges changes as one transaction. The error begins with the place of the
// failed change, which `place_of` returns by index.
absl::StatusOr<v1::BatchEditResponse> SendBatch(
    const Client& client, const std::string& database, std::span<const v1::Change> changes,
    const std::function<std::string(std::size_t)>& place_of);

// Sends the changes in order, kMaxBatchChanges in a transaction, into `sent`, also those before an
// error. The error is as of SendBatch, and states how many changes are stored.
absl::Status SendChanges(const Client& client, const std::string& database,
                         const std::vector<v1::Change>& changes,
                         const std::function<std::string(std::size_t)>& place_of,
                         SentChanges& sent);

// Waits until the model fits the changes, unless `operation` is empty. `done` tells what is stored.
absl::Status WaitForModel(const Client& client, const std::string& operation,
                          const std::string& done);

}  // namespace motiondb::client
