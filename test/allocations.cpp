#include "allocations.h"

#include "sanitized.h"

#include <malloc.h>

namespace {

thread_local long allocations_of_thread = 0;

}  // namespace

#ifdef PROXIMITY_SANITIZED

extern "C" {
int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*, std::size_t),
                                              void (*on_free)(const volatile void*));
std::size_t __sanitizer_get_current_allocated_bytes();
}

namespace {

void count(const volatile void*, std::size_t) { ++allocations_of_thread; }
void ignore(const volatile void*) {}
const int kInstalled = __sanitizer_install_malloc_and_free_hooks(count, ignore);

}  // namespace

std::size_t proximity_server::heapInUse() { return __sanitizer_get_current_allocated_bytes(); }

#else

// operator new ends in malloc; here it is the C library's, counted.
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT(bugprone-reserved-identifier)
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT(bugprone-reserved-identifier)
void* __libc_realloc(void* pointer, std::size_t size);           // NOLINT(bugprone-reserved-identifier)
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT(bugprone-reserved-identifier)

void* malloc(std::size_t size) {
  ++allocations_of_thread;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations_of_thread;
  return __libc_calloc(count, size);
}
void* realloc(void* pointer, std::size_t size) {
  ++allocations_of_thread;
  return __libc_realloc(pointer, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations_of_thread;
  return __libc_memalign(alignment, size);
}
}

std::size_t proximity_server::heapInUse() {
  const struct mallinfo2 heap = mallinfo2();
  return heap.uordblks + heap.hblkhd;  // hblkhd: blocks so large that they are mapped by themselves
}

#endif

long proximity_server::allocations() { return allocations_of_thread; }
