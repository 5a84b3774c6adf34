// The interpreter with the runtime of the sanitizers with which all is built: an instrumented module does not load into
// a Python that has none.
#include <Python.h>

// Python itself frees little at its end, and makes a MemoryError of what it does not get. The names are the
// sanitizers'.
extern "C" const char* __asan_default_options() { return "detect_leaks=0:allocator_may_return_null=1"; }  // NOLINT
extern "C" const char* __tsan_default_options() { return "allocator_may_return_null=1"; }                 // NOLINT

int main(int argc, char** argv) { return Py_BytesMain(argc, argv); }
