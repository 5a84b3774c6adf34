#include "allocations.h"

#include "sanitized.h"

#include <cstddef>

namespace {

thread_local long allocations_of_thread = 0;

}  // namespace

#ifdef PROXIMITY_SANITIZED

extern "C" {
int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*, std::size_t),
                                              void (*on_free)(const volatile void*));
}

namespace {

void count(const volatile void*, std::size_t) { ++allocations_of_thread; }
void ignore(const volatile void*) {}
const int kInstalled = __sanitizer_install_malloc_and_free_hooks(count, ignore);

}  // namespace

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

#endif

long proximity_server::allocations() { return allocations_of_thread; }
