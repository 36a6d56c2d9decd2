#include <fmt/format.h>

#include <map>

#include "core/motion/error.h"
#include "tests/eval/protocols/protocol.h"

namespace motiondb::tests {
namespace {

using Errors = std::array<double, kHorizonSeconds.size()>;

// Returns for each action the mean over all its windows.
std::map<std::string, Errors> ErrorsByAction(const MethodForecasts& method) {
  std::map<std::string, Errors> errors;
  std::map<std::string, int> windows;
  for (const ScoredForecast& forecast : method.forecasts) {
    Errors& sum = errors.try_emplace(forecast.clip->label, Errors{}).first->second;
    for (std::size_t h = 0; h < sum.size(); ++h) sum[h] += forecast.error_mm[h];
    ++windows[forecast.clip->label];
  }
  for (auto& [action, sum] : errors) {
    for (double& error : sum) error /= windows[action];
  }
  return errors;
}

std::vector<Column> HorizonColumns() {
  std::vector<Column> columns;
  for (const double seconds : kHorizonSeconds) {
    columns.push_back({fmt::format("{:.0f} ms", 1000 * seconds)});
  }
  return columns;
}

void AddTables(const std::string& half, const std::string& how, int window_step,
               const std::vector<MethodForecasts>& methods, Tables& tables) {
  Table means{.title = fmt::format("Mean 3-D error, mm, {}: mean of the actions", half),
              .columns = HorizonColumns()};
  means.columns.insert(means.columns.end(), {{"model, MB", 2}, {"ms per query", 2}});
  std::map<std::string, Table> by_action;
  for (const MethodForecasts& method : methods) {
    const auto errors = ErrorsByAction(method);
    Errors mean{};
    for (const auto& [action, of_action] : errors) {
      Table& table = by_action[action];
      table.title = fmt::format("Mean 3-D error, mm, {}: {}", half, action);
      table.columns = HorizonColumns();
      table.rows.push_back({method.name, {of_action.begin(), of_action.end()}});
      for (std::size_t h = 0; h < mean.size(); ++h) {
        mean[h] += of_action[h] / static_cast<double>(errors.size());
      }
    }
    Row& row = means.rows.emplace_back(Row{method.name, {mean.begin(), mean.end()}, method.chosen});
    row.figures.insert(row.figures.end(),
                       {1e-6 * method.model_bytes,
                        1e3 * method.seconds / static_cast<double>(method.forecasts.size())});
  }
  means.notes.push_back(
      fmt::format("{} Over all points; {} windows, {}.", how, methods.front().forecasts.size(),
                  window_step == 1 ? "every window" : fmt::format("every {} frames", window_step)));
  tables.push_back(std::move(means));
  for (auto& [action, table] : by_action) tables.push_back(std::move(table));
}

}  // namespace

absl::StatusOr<Tables> RunPrediction(Studies& studies) {
  PredictionStudy& study = studies.prediction;
  Tables tables;
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<MethodForecasts>* const held_out,
                            study.LeaveOneOut());
  AddTables("training half", "Each clip is held out in turn.", study.window_step(), *held_out,
            tables);
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<MethodForecasts>* const test, study.TrainToTest());
  if (!test->empty()) {
    AddTables("test half", "Trained on the training half.", study.window_step(), *test, tables);
  }
  return tables;
}

}  // namespace motiondb::tests
