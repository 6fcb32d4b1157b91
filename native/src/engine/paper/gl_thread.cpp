// Posted functions → calls on the one thread where the OpenGL context is current.
#include "engine/paper/gl_thread.h"

#include <algorithm>
#include <utility>

#include "support/error.h"
#include "support/math.h"
#include "support/process.h"

#include "shared.h"

namespace paradesc {

GlThread::GlThread(bool software, int device_index, const DriverSubstitute &substitute) : process_(this_process()) {
  Shared &shared = *shared_;
  shared.thread = std::thread([=, this] { loop(software, device_index, substitute); });
  std::unique_lock lock(shared.mutex);
  shared.changed.wait(lock, [&] { return shared.ready; });
  if (!shared.error) return;
  lock.unlock();
  shared.thread.join();
  std::rethrow_exception(shared.error);
}

GlThread::~GlThread() {
  if (is_left_behind()) {
    static_cast<void>(shared_.release());
    return;
  }
  {
    std::lock_guard lock(shared_->mutex);
    shared_->stop = true;
  }
  shared_->changed.notify_all();
  shared_->thread.join();
}

bool GlThread::is_left_behind() const { return process_ != this_process(); }

void GlThread::run(const std::function<void(const Gl &, ProgramCache &)> &work) {
  if (is_left_behind())
    throw Error(PDESC_ERROR_DEVICE_LOST,
                "The graphics device stayed with the process that this one was forked from; start processes "
                "by spawn, or use the cpu backend.");
  Shared &shared = *shared_;
  std::lock_guard one_caller(shared.calls);
  std::unique_lock lock(shared.mutex);
  shared.work = &work;
  shared.error = nullptr;
  lock.unlock(); // otherwise the thread would wake up only to wait for the lock
  shared.changed.notify_all();
  lock.lock();
  shared.changed.wait(lock, [&] { return shared.work == nullptr; });
  if (shared.error) std::rethrow_exception(std::exchange(shared.error, nullptr));
}

void GlThread::loop(bool software, int device_index, const DriverSubstitute &substitute) {
  Shared &shared = *shared_;
  std::unique_ptr<GlContext> context;
  std::unique_lock lock(shared.mutex);
  try {
    context = std::make_unique<GlContext>(software, device_index, substitute);
    device_ = context->device();
    const GlLimits &limits = context->gl().limits;
    group_size_ = limits.group_size;
    largest_dispatch_ = std::min(limits.work_groups, (1 << 30) / group_size_) * group_size_;
  } catch (...) {
    shared.error = std::current_exception();
  }
  shared.ready = true;
  shared.changed.notify_all();
  if (shared.error) return;

  ProgramCache programs;
  while (true) {
    shared.changed.wait(lock, [&] { return shared.work || shared.stop; });
    if (!shared.work) break;
    lock.unlock();
    std::exception_ptr error;
    try {
      (*shared.work)(context->gl(), programs);
    } catch (const Error &failure) {
      shared.lost = shared.lost || failure.status() == PDESC_ERROR_DEVICE_LOST;
      error = std::current_exception();
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    shared.error = error;
    shared.work = nullptr;
    lock.unlock();
    shared.changed.notify_all();
    lock.lock();
  }
  programs.clear();
}

} // namespace paradesc
