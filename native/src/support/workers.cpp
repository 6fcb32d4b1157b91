// A loop is called out; who comes takes part, and its caller waits for no one else.
#include "support/workers.h"

#include <system_error>
#include <utility>

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace paradesc {

static thread_local Workers *workers_here = nullptr;

// A process that was forked has none of the threads of the one before it.
static long this_process() {
#if defined(__unix__) || defined(__APPLE__)
  return getpid();
#else
  return 0;
#endif
}

Workers::~Workers() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  called_.notify_all();
  for (std::thread &thread : threads_) process_ == this_process() ? thread.join() : thread.detach();
}

// So many in all; fewer if the system gives no more.
void Workers::start(size_t count) {
  if (process_ != this_process()) {
    for (std::thread &thread : threads_) thread.detach();
    threads_.clear();
    process_ = this_process();
  }
  try {
    while (threads_.size() < count) threads_.emplace_back([this] { serve(); });
  } catch (const std::system_error &) {
  }
}

void Workers::serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    called_.wait(lock, [&] { return closing_ || wanted_ > 0; });
    if (wanted_ == 0) return;
    --wanted_;
    ++inside_;
    const std::function<void()> &work = *work_;
    lock.unlock();
    work();
    lock.lock();
    if (--inside_ == 0) ended_.notify_one();
  }
}

Workers::Scope::Scope(Workers &workers) : before_(std::exchange(workers_here, &workers)) {}

Workers::Scope::~Scope() { workers_here = before_; }

Workers::Loop::Loop(int count, const std::function<void()> &work) {
  if (count < 1) return;
  workers_ = workers_here;
  if (!workers_ || workers_->in_use_) {
    own_ = std::make_unique<Workers>();
    workers_ = own_.get();
  }
  workers_->in_use_ = true;
  workers_->start(static_cast<size_t>(count));
  {
    const std::lock_guard lock(workers_->mutex_);
    workers_->work_ = &work;
    workers_->wanted_ = static_cast<size_t>(count);
  }
  count == 1 ? workers_->called_.notify_one() : workers_->called_.notify_all();
}

Workers::Loop::~Loop() {
  if (!workers_) return;
  std::unique_lock lock(workers_->mutex_);
  workers_->wanted_ = 0;
  workers_->ended_.wait(lock, [&] { return workers_->inside_ == 0; });
  workers_->in_use_ = false;
}

bool Workers::Loop::wait(std::chrono::milliseconds patience) {
  if (!workers_) return true;
  std::unique_lock lock(workers_->mutex_);
  workers_->wanted_ = 0;
  return workers_->ended_.wait_for(lock, patience, [&] { return workers_->inside_ == 0; });
}

} // namespace paradesc
