#pragma once
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>

namespace sinew::record {

/// Entries of any size from one thread to another one, or to the same. All memory is taken, and touched, when it is
/// made; afterwards neither side uses the heap, a lock or a system call.
class Ring
{
public:
    /// Rounded up to a power of two, and to 4 kB.
    explicit Ring(std::size_t bytes)
        : size_(std::bit_ceil(std::max<std::size_t>(bytes, 4096))), memory_(std::make_unique<std::byte[]>(size_))
    {
    }

    // ---- for the one who writes ----

    /// A place for an entry; nullptr: full. Nobody sees it before `commit`. An entry may be half as large as the ring.
    std::byte* reserve(std::size_t bytes)
    {
        const std::size_t need = padded(bytes) + head_size;
        std::size_t at = written_ & (size_ - 1);
        const std::size_t to_end = size_ - at;
        const std::size_t skip = need > to_end ? to_end : 0;
        if (need > size_ / 2 || !has_room(skip + need))
            return nullptr;
        if (skip != 0) {
            put_head(at, skipped);
            at = 0;
        }
        put_head(at, bytes);
        reserved_ = written_ + skip + need;
        return memory_.get() + at + head_size;
    }
    void commit()
    {
        written_ = reserved_;
        shown_.store(written_, std::memory_order_release);
    }

    // ---- for the one who reads ----

    /// The oldest entry, aligned to 8 bytes; empty with data() nullptr: there is none. Valid until `pop`.
    std::span<const std::byte> front()
    {
        for (;;) {
            if (read_ == shown_.load(std::memory_order_acquire))
                return {};
            const std::size_t at = read_ & (size_ - 1);
            std::uint64_t bytes = 0;
            std::memcpy(&bytes, memory_.get() + at, head_size);
            if (bytes != skipped)
                return {memory_.get() + at + head_size, bytes};
            read_ += size_ - at;
        }
    }
    /// Frees the entry that `front` has shown.
    void pop()
    {
        read_ += padded(front().size()) + head_size;
        freed_.store(read_, std::memory_order_release);
    }

    std::size_t size() const { return size_; }
    /// How much of it is in use, as the one who writes sees it.
    std::size_t in_use() const { return static_cast<std::size_t>(written_ - freed_.load(std::memory_order_relaxed)); }

private:
    static constexpr std::size_t head_size = 8;
    static constexpr std::uint64_t skipped = ~0ULL;

    static constexpr std::size_t padded(std::size_t bytes) { return (bytes + 7) / 8 * 8; }
    bool has_room(std::size_t need)
    {
        if (written_ + need - freed_seen_ <= size_)
            return true;
        freed_seen_ = freed_.load(std::memory_order_acquire);
        return written_ + need - freed_seen_ <= size_;
    }
    void put_head(std::size_t at, std::uint64_t value) { std::memcpy(memory_.get() + at, &value, head_size); }

    static constexpr std::size_t cache_line = 64;
    std::size_t size_;
    std::unique_ptr<std::byte[]> memory_;
    // Counts of bytes since the beginning; what one side writes lies apart from what the other one writes.
    alignas(cache_line) std::atomic<std::uint64_t> shown_{0};
    std::uint64_t written_ = 0, reserved_ = 0, freed_seen_ = 0;
    alignas(cache_line) std::atomic<std::uint64_t> freed_{0};
    std::uint64_t read_ = 0;
};

} // namespace sinew::record
