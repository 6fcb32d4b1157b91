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

Workers::Workers() : process_(this_process()) {}

Workers::~Workers() {
  leave_to_other_process();
  {
    const std::lock_guard lock(call_->mutex);
    call_->closing = true;
  }
  call_->called.notify_all();
  for (std::thread &thread : threads_) thread.join();
}

// After a fork: one of the threads that are gone may have held the lock, and been waited for. So what they shared is left as it
// is.
void Workers::leave_to_other_process() {
  if (process_ == this_process()) return;
  process_ = this_process();
  for (std::thread &thread : threads_) thread.detach();
  threads_.clear();
  static_cast<void>(call_.release());
  call_ = std::make_unique<Call>();
  in_use_ = false;
}

// So many in all; fewer if the system gives no more.
void Workers::start(size_t count) {
  try {
    while (threads_.size() < count) threads_.emplace_back([&call = *call_] { serve(call); });
  } catch (const std::system_error &) {
  }
}

void Workers::serve(Call &call) {
  std::unique_lock lock(call.mutex);
  for (;;) {
    call.called.wait(lock, [&] { return call.closing || call.wanted > 0; });
    if (call.wanted == 0) return;
    --call.wanted;
    ++call.inside;
    const std::function<void()> &work = *call.work;
    lock.unlock();
    work();
    lock.lock();
    if (--call.inside == 0) call.ended.notify_one();
  }
}

Workers::Scope::Scope(Workers &workers) : before_(std::exchange(workers_here, &workers)) {}

Workers::Scope::~Scope() { workers_here = before_; }

Workers::Loop::Loop(int count, const std::function<void()> &work) {
  if (count < 1) return;
  workers_ = workers_here;
  if (workers_) workers_->leave_to_other_process();
  if (!workers_ || workers_->in_use_) {
    own_ = std::make_unique<Workers>();
    workers_ = own_.get();
  }
  workers_->in_use_ = true;
  workers_->start(static_cast<size_t>(count));
  {
    const std::lock_guard lock(workers_->call_->mutex);
    workers_->call_->work = &work;
    workers_->call_->wanted = static_cast<size_t>(count);
  }
  count == 1 ? workers_->call_->called.notify_one() : workers_->call_->called.notify_all();
}

Workers::Loop::~Loop() {
  if (!workers_) return;
  Call &call = *workers_->call_;
  std::unique_lock lock(call.mutex);
  call.wanted = 0;
  call.ended.wait(lock, [&] { return call.inside == 0; });
  workers_->in_use_ = false;
}

bool Workers::Loop::wait(std::chrono::milliseconds patience) {
  if (!workers_) return true;
  Call &call = *workers_->call_;
  std::unique_lock lock(call.mutex);
  call.wanted = 0;
  return call.ended.wait_for(lock, patience, [&] { return call.inside == 0; });
}

} // namespace paradesc
