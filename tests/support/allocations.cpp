#include "tests/support/allocations.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

// The thread sanitizer has operators of its own and takes no others beside them; then nothing is counted.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define SINEW_COUNTS_NOTHING
#endif
#endif

namespace {

std::atomic<std::uint64_t> count{0};

} // namespace

#ifndef SINEW_COUNTS_NOTHING
namespace {

void* allocate(std::size_t size)
{
    count.fetch_add(1, std::memory_order_relaxed);
    if (void* memory = std::malloc(size))
        return memory;
    throw std::bad_alloc();
}

} // namespace

void* operator new(std::size_t size)
{
    return allocate(size);
}

void* operator new[](std::size_t size)
{
    return allocate(size);
}

void operator delete(void* memory) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory, std::size_t) noexcept
{
    std::free(memory);
}

#endif

std::uint64_t sinew::support::allocations()
{
    return count.load(std::memory_order_relaxed);
}
