"""Asks a program's own allocator how much memory it uses: the C library, or jemalloc, as in Debian's Blender."""

import ctypes

EVERY_ARENA = 4096  # jemalloc's MALLCTL_ARENAS_ALL


class _MallocInfo(ctypes.Structure):
    """glibc's struct mallinfo2."""

    _fields_ = [
        (name, ctypes.c_size_t)
        for name in (
            "arena",
            "ordblks",
            "smblks",
            "hblks",
            "hblkhd",
            "usmblks",
            "fsmblks",
            "uordblks",
            "fordblks",
            "keep",
        )
    ]


def give_back() -> None:
    """Gives free memory back to the system: the allocator keeps it for each thread, and how much it keeps is chance."""
    library = ctypes.CDLL(None)
    library.malloc_trim(0)
    if hasattr(library, "mallctl"):
        library.mallctl(f"arena.{EVERY_ARENA}.purge".encode(), None, None, None, ctypes.c_size_t(0))


def megabytes_in_use() -> float:
    """The memory that has been allocated and not freed; 0 if the allocator does not tell."""
    library = ctypes.CDLL(None)
    if hasattr(library, "mallctl"):
        epoch, allocated = ctypes.c_uint64(1), ctypes.c_size_t(0)
        size = ctypes.c_size_t(ctypes.sizeof(allocated))
        # Its figures are those of the last epoch.
        library.mallctl(b"epoch", None, None, ctypes.byref(epoch), ctypes.c_size_t(ctypes.sizeof(epoch)))
        library.mallctl(b"stats.allocated", ctypes.byref(allocated), ctypes.byref(size), None, ctypes.c_size_t(0))
        return allocated.value / 2**20
    if hasattr(library, "mallinfo2"):  # glibc 2.33
        library.mallinfo2.restype = _MallocInfo
        info = library.mallinfo2()
        return (info.uordblks + info.hblkhd) / 2**20
    return 0.0
