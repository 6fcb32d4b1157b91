// Posted functions → calls on the one thread where the OpenGL context is current.
#include "engine/opengl/gl_thread.h"

#include <algorithm>
#include <utility>

#include "support/error.h"
#include "support/math.h"

#include "shared.h"

namespace paradesc {

GlThread::GlThread(bool software, int device_index, const DriverSubstitute &substitute)
    : thread_([=, this] { loop(software, device_index, substitute); }) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return ready_; });
  if (!error_) return;
  lock.unlock();
  thread_.join();
  std::rethrow_exception(error_);
}

GlThread::~GlThread() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void GlThread::run(const std::function<void(const Gl &, ProgramCache &)> &work) {
  std::lock_guard one_caller(calls_);
  std::unique_lock lock(mutex_);
  work_ = &work;
  error_ = nullptr;
  lock.unlock(); // or the thread would wake up only to wait for it
  changed_.notify_all();
  lock.lock();
  changed_.wait(lock, [&] { return work_ == nullptr; });
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void GlThread::loop(bool software, int device_index, const DriverSubstitute &substitute) {
  std::unique_ptr<GlContext> context;
  std::unique_lock lock(mutex_);
  try {
    context = std::make_unique<GlContext>(software, device_index, substitute);
    device_ = context->device();
    const GlLimits &limits = context->gl().limits;
    group_size_ = limits.group_size;
    list_texels_ = limits.list_texels;
    largest_dispatch_ = std::min(limits.work_groups, (1 << 30) / group_size_) * group_size_;
  } catch (...) {
    error_ = std::current_exception();
  }
  ready_ = true;
  changed_.notify_all();
  if (error_) return;

  ProgramCache programs;
  while (true) {
    changed_.wait(lock, [&] { return work_ || stop_; });
    if (!work_) break;
    lock.unlock();
    std::exception_ptr error;
    try {
      (*work_)(context->gl(), programs);
    } catch (const Error &failure) {
      lost_ = lost_ || failure.status() == PDESC_ERROR_DEVICE_LOST;
      error = std::current_exception();
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    error_ = error;
    work_ = nullptr;
    lock.unlock();
    changed_.notify_all();
    lock.lock();
  }
  programs.clear();
}

} // namespace paradesc
