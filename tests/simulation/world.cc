#include "tests/simulation/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>

namespace motiondb::simulation {
namespace {

// 2026-01-01.
constexpr std::int64_t kStart_us = 1'767'225'600'000'000;

}  // namespace

World::World(std::uint64_t seed) : seed_(seed), random_(seed) { current_ = this; }

World::~World() { current_ = nullptr; }

std::int64_t World::WallMicroseconds() {
  now_ += microseconds(1);
  const Duration offset = process() == nullptr || steps_ > 0 ? Duration() : process()->clock_offset;
  const Duration since_start = now_.time_since_epoch() + offset;
  return kStart_us + std::chrono::duration_cast<microseconds>(since_start).count();
}

World::EventPointer World::At(Time time, Process* process, std::function<void()> action) {
  auto event = std::make_shared<Event>(Event{time, random_(), process, std::move(action)});
  events_.insert(event);
  return event;
}

void World::Remove(const EventPointer& event) {
  if (event != nullptr) events_.erase(event);
}

void World::Start(Process* process, std::function<void()> body, Duration delay) {
  auto task = std::make_shared<Task>(Task{process});
  task->fiber = std::make_unique<Fiber>(std::move(body));
  tasks_[task.get()] = task;
  At(now_ + delay, process, [this, task] { Run(task); });
}

void World::Run(const std::shared_ptr<Task>& task) {
  task_ = task.get();
  task->fiber->Resume();
  task_ = nullptr;
  if (task->fiber->has_ended()) tasks_.erase(task.get());
}

void World::RunUntil(Time end) {
  while (!events_.empty() && (*events_.begin())->time <= end) {
    const EventPointer event = *events_.begin();
    events_.erase(events_.begin());
    now_ = std::max(now_, event->time);
    Process* const process = event->process;
    if (process != nullptr && process->paused_until > now_ && !process->is_dead) {
      event->time = std::min(process->paused_until, now_ + milliseconds(100));
      event->tie = random_();
      events_.insert(event);
      continue;
    }
    const std::function<void()> action = std::move(event->action);
    action();
    if (after_event) after_event(process);
  }
  now_ = std::max(now_, end);
}

void World::Sleep(Duration duration) {
  if (steps_ > 0 || task_ == nullptr) return;
  Task* const task = task_;
  if (task->process != nullptr && task->process->is_dead) duration = {};
  At(now_ + duration, task->process, [this, task = tasks_.at(task)] { Run(task); });
  task->fiber->Pause();
}

void World::Suspend() {
  if (steps_ > 0 || task_ == nullptr) Fail("something waits where nothing else can run");
  task_->fiber->Pause();
}

void World::Wake(Task* task) {
  At(now_, task->process, [this, shared = tasks_.at(task)] { Run(shared); });
}

void World::Preempt() {
  if (task_ == nullptr || task_->mutexes > 0 || steps_ > 0 || std::uncaught_exceptions() > 0 ||
      !Chance(hazards.preemption)) {
    return;
  }
  Sleep(Chance(0.02) ? Between({}, seconds(2)) : Between({}, milliseconds(2)));
}

void World::Fail(const std::string& what) {
  fmt::print("seed {} at {:.6f} s: {}\n", seed_,
             std::chrono::duration<double>(now_.time_since_epoch()).count(), what);
  std::fflush(stdout);
  std::_Exit(EXIT_FAILURE);
}

void World::Trace(const std::string& line) {
  const std::string timed = fmt::format(
      "{:10.6f} {:3} {}", std::chrono::duration<double>(now_.time_since_epoch()).count(),
      process() == nullptr ? "-" : process()->name, line);
  for (const char c : timed) {
    trace_hash_ = (trace_hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  }
  if (prints_trace_) fmt::print("{}\n", timed);
}

void WaitList::Wait() {
  World& world = World::Current();
  Task* const task = world.task();
  if (task == nullptr) world.Fail("something waits outside of tasks");
  tasks_.push_back(task);
  task->waits_in = this;
  world.Suspend();
}

bool WaitList::WaitUntil(Time end) {
  World& world = World::Current();
  Task* const task = world.task();
  bool is_late = false;
  const auto timeout = world.At(end, world.process(), [task, &world, &is_late] {
    if (task->waits_in == nullptr) return;  // woken, but it did not run yet
    std::erase(task->waits_in->tasks_, task);
    task->waits_in = nullptr;
    is_late = true;
    world.Wake(task);
  });
  Wait();
  world.Remove(timeout);
  return !is_late;
}

void WaitList::WakeOne() {
  if (tasks_.empty()) return;
  World& world = World::Current();
  const auto next = tasks_.begin() + static_cast<std::ptrdiff_t>(world.Below(tasks_.size()));
  Task* const task = *next;
  tasks_.erase(next);
  task->waits_in = nullptr;
  world.Wake(task);
}

void WaitList::WakeAll() {
  while (!tasks_.empty()) WakeOne();
}

void TaskMutex::Lock() {
  if (!World::Exists()) return;
  World& world = World::Current();
  world.Preempt();
  while (is_held_) waiting_.Wait();
  is_held_ = true;
  if (world.task() != nullptr) ++world.task()->mutexes;
}

void TaskMutex::Unlock() {
  if (!World::Exists()) return;
  is_held_ = false;
  World& world = World::Current();
  if (world.task() != nullptr) --world.task()->mutexes;
  waiting_.WakeOne();
}

bool TaskMutex::TryLock() {
  if (is_held_) return false;
  Lock();
  return true;
}

}  // namespace motiondb::simulation
