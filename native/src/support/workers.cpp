// A loop is announced; any worker that is free joins, and the caller does not wait for the others.
#include "support/workers.h"

#include <new>
#include <system_error>
#include <utility>

#include "support/process.h"

namespace paradesc {

static thread_local Workers *workers_here = nullptr;

Workers::Workers() : process_(this_process()) {}

Workers::~Workers() {
  if (process_ != this_process()) {
    static_cast<void>(call_.release());
    return;
  }
  {
    const std::lock_guard lock(call_->mutex);
    call_->closing = true;
  }
  call_->called.notify_all();
  for (std::thread &thread : call_->threads) thread.join();
}

// After a fork the other threads do not exist here, but one of them may have held the lock, and would be waited for. So the
// threads and their shared state are abandoned.
void Workers::leave_to_other_process() {
  if (process_ == this_process()) return;
  auto call = std::make_unique<Call>();
  call.swap(call_);
  static_cast<void>(call.release());
  process_ = this_process();
  in_use_ = false;
}

// Starts threads up to this total; fewer if the system has no more threads, or no memory for them.
void Workers::start(size_t count) {
  Call &call = *call_;
  try {
    while (call.threads.size() < count) call.threads.emplace_back([&call] { serve(call); });
  } catch (const std::system_error &) {
  } catch (const std::bad_alloc &) {
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
