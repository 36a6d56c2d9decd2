// A narrow way to a pool of threads: at most so many pieces of the work that goes through it run at
// a time, and the others wait in order. Heavy work, which would else take every thread for seconds,
// leaves the rest to light work. Thread-safe; outlives its work.
#pragma once

#include <boost/asio/thread_pool.hpp>
#include <deque>
#include <functional>
#include <mutex>

namespace motiondb::server {

class Lane {
 public:
  // `width`: at least 1.
  Lane(boost::asio::thread_pool& pool, int width) : pool_(pool), free_(width) {}

  // Runs a piece of work, which must not throw, on a thread of the pool.
  void Post(std::function<void()> work);

 private:
  void Start(std::function<void()> work);
  void Next();

  boost::asio::thread_pool& pool_;
  std::mutex mutex_;
  int free_;
  std::deque<std::function<void()>> waiting_;
};

}  // namespace motiondb::server
