"""A team of threads that work on one lane, and where they wait for one another.

Every thread runs the same kernel with a number of its own, its rank. All of them pass `meet`
together: what one wrote before is there for the others after it. On the CPU each is a launch of its
own from a thread of Python; on any other device the team is one block of threads.
"""

import warp as wp


@wp.struct
class Crew:
    """A team as a launch sees it.

    Attributes:
        rank: Number of this launch's first thread.
        size: Threads of the team.
        steps: Most steps of the launch.
        gate: Those that wait [0], and how often all have met [16], apart by a line of the cache.
        give_way: Address of a function of the system that lets other threads run; 0 for none.
    """

    rank: int
    size: int
    steps: int
    gate: wp.array(dtype=int)
    give_way: wp.uint64


_MEET = """
#if defined(__CUDA_ARCH__)
__syncthreads();
#else
if (threads > 1) {
    int* waiting = reinterpret_cast<int*>(gate);
    int* met = waiting + 16;
    int before = __atomic_load_n(met, __ATOMIC_ACQUIRE);
    if (__atomic_add_fetch(waiting, 1, __ATOMIC_ACQ_REL) == threads) {
        __atomic_store_n(waiting, 0, __ATOMIC_RELAXED);
        __atomic_store_n(met, before + 1, __ATOMIC_RELEASE);
    } else {
        int looks = 0;
        while (__atomic_load_n(met, __ATOMIC_ACQUIRE) == before) {
            looks += 1;
            if (looks > 2000 && give_way != 0) {
                typedef int yield_t(void);
                reinterpret_cast<yield_t*>(give_way)();
            }
        }
    }
}
#endif
"""
# A thread that waits looks some microseconds long, the time that others need; then it gives way.


@wp.func_native(_MEET)
def _meet(gate: wp.uint64, threads: int, give_way: wp.uint64):
    """Waits until all threads of a team are here."""


@wp.func
def meet(crew: Crew):
    """Waits until all threads of a team are here."""
    _meet(crew.gate.ptr, crew.size, crew.give_way)


@wp.func
def share(crew: Crew, rank: int, count: int) -> int:
    """Where the part of a thread begins of `count` things in a row; that of rank + 1 ends it."""
    return (count * rank) // crew.size
