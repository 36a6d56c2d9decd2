// The simulated machine of one seed: time, randomness, and tasks, which take the place of threads.
// Everything runs on one thread. A task runs until it waits; the seed decides which one is next, so
// the same seed gives the same run.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/simulation/fiber.h"

namespace motiondb::simulation {

struct StoreCall;  // simulated_store.h
class WaitList;

using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;
using Duration = Clock::duration;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

// A run of a simulated server process. Clients have none.
struct Process {
  std::string name;
  Duration clock_offset{};  // of its wall clock
  Time paused_until{};      // stopped, as by SIGSTOP
  Time cut_off_until{};     // it does not reach the store
  bool is_dead = false;     // its tasks end without an effect on the store or on clients
};

// How often unusual things happen, by seed.
struct Hazards {
  double preemption = 0;      // a task is interrupted when it locks a mutex
  double long_work = 0;       // a parallel loop takes up to two seconds
  double slow_call = 0;       // a transaction takes up to eight seconds
  double refused_call = 0;    // a transaction fails before it begins
  double lost_answer = 0;     // a transaction fails after its commit
  double lost_extension = 0;  // the same, of an extension of a model
  double lost_message = 0;    // a call of a client, or its answer, is lost
  double lost_notice = 0;     // a notification of the store is lost
};

// A task. While it waits, it is in a list or has an event.
struct Task {
  Process* process = nullptr;
  std::unique_ptr<Fiber> fiber = {};
  int mutexes = 0;                  // that it holds
  const StoreCall* call = nullptr;  // that it is in
  WaitList* waits_in = nullptr;     // until it is woken
};

class World {
 public:
  struct Event {
    Time time;
    std::uint64_t tie = 0;
    Process* process = nullptr;
    std::function<void()> action;
  };
  using EventPointer = std::shared_ptr<Event>;

  explicit World(std::uint64_t seed);
  // REQUIRES: no task exists, or the process is about to end.
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // REQUIRES: there is one.
  static World& Current() { return *current_; }
  static bool Exists() { return current_ != nullptr; }

  Time now() const { return now_; }
  // Wall clock of the running task's process, else of the store: microseconds since the Unix epoch.
  // Each call takes a microsecond, so that times identify what has them.
  std::int64_t WallMicroseconds();

  std::uint64_t Below(std::uint64_t count) { return random_() % count; }
  bool Chance(double probability) {
    return static_cast<double>(random_() >> 11) * 0x1p-53 < probability;
  }
  Duration Between(Duration least, Duration most) {
    return least + Duration(Below(static_cast<std::uint64_t>((most - least).count()) + 1));
  }

  // Runs an action at a time, or later if its process is paused. An action must not wait.
  EventPointer At(Time time, Process* process, std::function<void()> action);
  // Removes an event that has not run.
  void Remove(const EventPointer& event);
  // Runs `body`, which may wait, as a task of a process.
  void Start(Process* process, std::function<void()> body, Duration delay = {});
  // Runs events until a time.
  void RunUntil(Time end);
  std::size_t task_count() const { return tasks_.size(); }

  // The running task; null: none.
  Task* task() const { return task_; }
  Process* process() const { return task_ == nullptr ? nullptr : task_->process; }
  // Pauses the running task. It continues at a time, and immediately if its process is dead or
  // within a transaction.
  void Sleep(Duration duration);
  // Pauses the running task until Wake. REQUIRES: not within a transaction.
  void Suspend();
  // Lets it continue.
  void Wake(Task* task);
  // Sometimes lets other tasks run.
  void Preempt();

  // A transaction of the store is one step: within it nothing else runs.
  class Step {
   public:
    Step() { ++Current().steps_; }
    ~Step() { --Current().steps_; }
    Step(const Step&) = delete;
    Step& operator=(const Step&) = delete;
  };

  // A broken invariant ends the process: tasks cannot be ended from outside.
  [[noreturn]] void Fail(const std::string& what);
  // Adds a line to the trace, and prints it if asked. It must not contain anything random that does
  // not come from the seed.
  void Trace(const std::string& line);
  std::uint64_t trace_hash() const { return trace_hash_; }
  static void set_prints_trace(bool prints) { prints_trace_ = prints; }

  Hazards hazards;
  std::function<void(Process*)> after_event;  // may be empty

 private:
  struct Order {
    bool operator()(const EventPointer& a, const EventPointer& b) const {
      return std::pair(a->time, a->tie) < std::pair(b->time, b->tie);
    }
  };
  void Run(const std::shared_ptr<Task>& task);

  static inline World* current_ = nullptr;
  static inline bool prints_trace_ = false;

  const std::uint64_t seed_;
  std::mt19937_64 random_;
  Time now_{};
  std::set<EventPointer, Order> events_;
  std::map<Task*, std::shared_ptr<Task>> tasks_;
  Task* task_ = nullptr;
  int steps_ = 0;
  std::uint64_t trace_hash_ = 0xcbf29ce484222325;
};

// Tasks that wait for something.
class WaitList {
 public:
  // Waits until it is woken.
  void Wait();
  // Returns false if nothing woke it until `end`.
  bool WaitUntil(Time end);
  void WakeOne();
  void WakeAll();

 private:
  std::vector<Task*> tasks_;
};

// A mutex of tasks.
class TaskMutex {
 public:
  void Lock();
  void Unlock();
  bool TryLock();

 private:
  bool is_held_ = false;
  WaitList waiting_;
};

}  // namespace motiondb::simulation
