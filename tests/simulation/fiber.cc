#include "tests/simulation/fiber.h"

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace motiondb::simulation {
namespace {

constexpr std::size_t kStackBytes = std::size_t{512} << 10;
constexpr std::size_t kGuardBytes = 4096;  // not accessible: an overflow ends the process

std::vector<void*> free_stacks;
Fiber* starting = nullptr;

void* TakeStack() {
  if (!free_stacks.empty()) {
    void* const stack = free_stacks.back();
    free_stacks.pop_back();
    return stack;
  }
  void* const stack = mmap(nullptr, kStackBytes, PROT_READ | PROT_WRITE,
                           MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK | MAP_NORESERVE, -1, 0);
  if (stack == MAP_FAILED || mprotect(stack, kGuardBytes, PROT_NONE) != 0) throw std::bad_alloc();
  return stack;
}

}  // namespace

Fiber::Fiber(std::function<void()> body) : body_(std::move(body)), stack_(TakeStack()) {
  getcontext(&inside_);
  inside_.uc_stack.ss_sp = stack_;
  inside_.uc_stack.ss_size = kStackBytes;
  inside_.uc_link = &outside_;
  makecontext(&inside_, &Fiber::Main, 0);
}

Fiber::~Fiber() { free_stacks.push_back(stack_); }

void Fiber::Resume() {
  starting = this;  // used only by Main
  swapcontext(&outside_, &inside_);
}

void Fiber::Pause() { swapcontext(&inside_, &outside_); }

void Fiber::Main() {
  Fiber& self = *starting;
  self.body_();
  self.body_ = nullptr;
  self.has_ended_ = true;
}

}  // namespace motiondb::simulation
