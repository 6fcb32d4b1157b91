// The patches of a flood if they are few: arrays that are always scanned as a whole, so that devices keep them in registers.
int patch_at[FLOOD_PATCHES];                             // -1: none
uint reached_at[FLOOD_PATCHES], pending_at[FLOOD_PATCHES]; // bits of triangles: visited, and still to be visited
int patches;

void begin_flood() {
  patches = 0;
  for (int i = 0; i < FLOOD_PATCHES; ++i) {
    patch_at[i] = -1;
    reached_at[i] = pending_at[i] = 0u;
  }
}

// Marks triangles of a patch as pending. Returns false if there is no room.
bool reach(int patch_number, uint bits) {
  bool found = false;
  for (int i = 0; i < FLOOD_PATCHES; ++i) {
    bool here = !found && (patch_at[i] == patch_number || patch_at[i] < 0);
    patches = here ? max(patches, i + 1) : patches;
    patch_at[i] = here ? patch_number : patch_at[i];
    pending_at[i] |= here ? bits & ~reached_at[i] : 0u;
    found = found || here;
  }
  patches = found ? patches : FLOOD_PATCHES + 1;
  return found;
}

// Stores the patch at a place, if there is one, and takes the next one with pending triangles. Returns false if there is none.
bool next_patch(inout int place, inout int patch_number, inout uint reached, out uint pending) {
  int next = -1;
  uint before = 0u;
  pending = 0u;
  for (int i = 0; i < FLOOD_PATCHES; ++i) {
    reached_at[i] = i == place ? reached : reached_at[i];
    bool here = next < 0 && pending_at[i] != 0u;
    next = here ? i : next;
    patch_number = here ? patch_at[i] : patch_number;
    before = here ? reached_at[i] : before;
    pending = here ? pending_at[i] : pending;
    pending_at[i] = here ? 0u : pending_at[i];
  }
  place = next;
  reached = before;
  return next >= 0;
}

// The patch at one of the FLOOD_PLACES places.
#define FLOOD_PLACES FLOOD_PATCHES
int patch_in(int place) {
  int number = -1;
  for (int i = 0; i < FLOOD_PATCHES; ++i) number = i == place ? patch_at[i] : number;
  return number;
}
uint reached_in(int place) {
  uint bits = 0u;
  for (int i = 0; i < FLOOD_PATCHES; ++i) bits = i == place ? reached_at[i] : bits;
  return bits;
}
