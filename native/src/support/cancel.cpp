// The scope of each thread, and the rule when its caller is asked.
#include "support/cancel.h"

#include <utility>

#include "support/error.h"

namespace paradesc {

thread_local std::chrono::milliseconds cancel_patience{10};

static thread_local CancelScope *scope_here = nullptr;

CancelScope::CancelScope(std::function<void()> ask) : ask_(std::move(ask)) {}

CancelScope::~CancelScope() = default;

CancelScope *CancelScope::current() { return scope_here; }

CancelScope::Member::Member(CancelScope *scope) : before_(std::exchange(scope_here, scope)) {}

CancelScope::Member::~Member() { scope_here = before_; }

void CancelScope::check() {
  if (stopped_) throw Error(PDESC_ERROR_CANCELLED, "Cancelled.");
  const auto now = std::chrono::steady_clock::now();
  if (std::this_thread::get_id() != owner_ || now - last_asked_ < cancel_patience) return;
  const Member nobody(nullptr); // the caller may call the library in turn
  try {
    ask_();
  } catch (...) {
    stopped_ = true;
    throw;
  }
  last_asked_ = std::chrono::steady_clock::now();
}

void checkpoint() {
  if (scope_here) scope_here->check();
}

} // namespace paradesc
