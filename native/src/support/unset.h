// Vectors for loops that write every item.
#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace paradesc {

// resize() leaves new items of plain types unset: setting millions of them to 0 on one core takes longer than writing them on
// all.
template <class T> struct LeaveUnset : std::allocator<T> {
  template <class Other> struct rebind { using other = LeaveUnset<Other>; };
  template <class Item> void construct(Item *place) { ::new (static_cast<void *>(place)) Item; }
  template <class Item, class... From> void construct(Item *place, From &&...from) {
    ::new (static_cast<void *>(place)) Item(std::forward<From>(from)...);
  }
};
template <class T> using UnsetVector = std::vector<T, LeaveUnset<T>>;

} // namespace paradesc
