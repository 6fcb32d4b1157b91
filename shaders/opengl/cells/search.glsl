// The parameters of a search's lists, their lengths, and their capacities.
#include "shared.h"
layout(std140, binding = BLOCK_SEARCH) uniform Search { SearchParams search; };
layout(std430, binding = BINDING_COUNTS) restrict buffer Counts { SearchCounts counts; };

// Return whether the lists of samples and cells have room, or all lists. If not, they are made longer and the search is repeated.
bool cells_fit() {
  return counts.samples <= search.room.samples && counts.fine <= search.room.fine && counts.cells <= search.room.cells &&
         counts.longest <= search.room.longest;
}

bool lists_fit() { return cells_fit() && counts.neighbors <= search.room.neighbors; }
