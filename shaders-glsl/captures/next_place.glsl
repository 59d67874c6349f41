// The next free index of a list.

#ifndef CAPTURES_NEXT_PLACE_GLSL
#define CAPTURES_NEXT_PLACE_GLSL

#define LIST_ACCESS
#include "captures/counts.glsl"

// Reserves and returns the next free index of the list. The dispatch over the list has a workgroup for each
// `entries_per_group` entries. The index may lie beyond the end of the list's buffer.
uint ReserveListIndex(uint entries_per_group) {
    uint index = atomicAdd(lost_counts.count, 1u);
    if (index % entries_per_group == 0u)
        atomicAdd(lost_counts.groups[0], 1u);
    if (index == 0u) {
        lost_counts.groups[1] = 1u;
        lost_counts.groups[2] = 1u;
    }
    return index;
}

#endif
