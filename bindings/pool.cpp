#include "pool.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <new>
#include <thread>

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
static long process() { return static_cast<long>(getpid()); }
#else
static long process() { return 0; }
#endif
#if defined(__linux__)
#include <sched.h>
#endif

namespace {

constexpr std::chrono::milliseconds kPatience{50};

class Pool {
 public:
  std::atomic_flag busy = ATOMIC_FLAG_INIT;  // one batch at a time; one from a signal handler meets its own thread's
  // Runs `job` on `helpers` threads and `own` on this one, which throw nothing; `meanwhile` is called now and then
  // while the others go on.
  void run(int helpers, const std::function<void()>& job, const std::function<void()>& own,
           const std::function<bool()>& meanwhile) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      helpers = start(helpers);
      job_ = &job;
      wanted_ = helpers;
      running_ = helpers;
      ++turn_;
    }
    wake_.notify_all();
    own();
    std::unique_lock<std::mutex> lock(mutex_);
    while (!done_.wait_for(lock, kPatience, [this] { return running_ == 0; })) {
      lock.unlock();
      meanwhile();
      lock.lock();
    }
    job_ = nullptr;
  }

 private:
  // As many threads as are wanted, or as the system allows.
  int start(int wanted) {
    try {
      for (; threads_ < wanted; ++threads_) std::thread([this, number = threads_] { loop(number); }).detach();
    } catch (const std::exception&) {  // no thread, or no memory for one
      return threads_;
    }
    return wanted;
  }
  void loop(int number) {
    long seen = 0;
    for (;;) {
      const std::function<void()>* job = nullptr;
      {
        std::unique_lock<std::mutex> lock(mutex_);
        wake_.wait(lock, [&] { return turn_ != seen; });
        seen = turn_;
        if (number < wanted_) job = job_;
      }
      if (!job) continue;
      (*job)();
      const std::lock_guard<std::mutex> lock(mutex_);
      if (--running_ == 0) done_.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const std::function<void()>* job_ = nullptr;
  int threads_ = 0, wanted_ = 0, running_ = 0;
  long turn_ = 0;
};

// The process's pool. A child of fork() has none of its parent's threads, and gets a pool of its own; the old one's
// locks may be held by threads that are gone, so it is left alone. Null where there is no memory for one.
Pool* pool() {
  static std::atomic<Pool*> current{nullptr};
  static std::atomic<long> owner{-1};
  if (owner.load() != process()) {
    static std::atomic_flag making = ATOMIC_FLAG_INIT;
    while (making.test_and_set()) std::this_thread::yield();
    if (owner.load() != process()) {
      Pool* const made = new (std::nothrow) Pool;
      current.store(made);
      if (made) owner.store(process());
    }
    making.clear();
  }
  return current.load();
}

}  // namespace

int default_threads() {
  if (const char* text = std::getenv("STILLREACH_THREADS")) {
    const long wanted = std::strtol(text, nullptr, 10);
    if (wanted >= 1) return static_cast<int>(std::min(wanted, 1024L));
  }
#if defined(__linux__)
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
#endif
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

bool run_blocks(std::ptrdiff_t count, std::ptrdiff_t block, int threads,
                const std::function<void(std::ptrdiff_t, std::ptrdiff_t, const Stopped&)>& work,
                const std::function<bool()>& between) {
  std::atomic<std::ptrdiff_t> next{0};
  std::atomic<bool> stop{false};
  std::atomic_flag failed = ATOMIC_FLAG_INIT;
  std::exception_ptr failure;  // the first one
  const auto take = [&](const Stopped& stopped) {
    try {
      while (!stopped()) {
        const std::ptrdiff_t first = next.fetch_add(block);
        if (first >= count) return;
        work(first, std::min(first + block, count), stopped);
      }
    } catch (...) {
      if (!failed.test_and_set()) failure = std::current_exception();
      stop = true;
    }
  };
  auto last = std::chrono::steady_clock::now();
  const Stopped told = [&] { return stop.load(std::memory_order_relaxed); };
  const Stopped asked = [&] {  // by the calling thread
    const auto now = std::chrono::steady_clock::now();
    if (now - last < kPatience) return told();
    last = now;
    if (!stop && !between()) stop = true;
    return told();
  };
  const int helpers = static_cast<int>(std::min<std::ptrdiff_t>(threads, (count + block - 1) / block)) - 1;
  Pool* shared = helpers > 0 ? pool() : nullptr;
  if (shared && !shared->busy.test_and_set()) {
    shared->run(helpers, [&] { take(told); }, [&] { take(asked); }, asked);
    shared->busy.clear();
  } else {
    take(asked);  // another batch has the pool
  }
  if (failure) std::rethrow_exception(failure);
  return !stop;
}
