#pragma once
#include <cstddef>
#include <vector>

namespace sinew::sim {

/// First in, first out, with a capacity that is fixed at construction: no heap after it.
template <class T>
class Ring
{
public:
    explicit Ring(std::size_t capacity) : all_(capacity) {}

    bool empty() const { return size_ == 0; }
    std::size_t size() const { return size_; }
    std::size_t room() const { return all_.size() - size_; }
    const T& front() const { return all_[first_]; }
    /// False, and nothing is added, when it is full.
    bool push(const T& item)
    {
        if (room() == 0)
            return false;
        all_[wrapped(first_ + size_++)] = item;
        return true;
    }
    void pop()
    {
        first_ = wrapped(first_ + 1);
        --size_;
    }

private:
    std::size_t wrapped(std::size_t place) const { return place < all_.size() ? place : place - all_.size(); }

    std::vector<T> all_;
    std::size_t first_ = 0;
    std::size_t size_ = 0;
};

} // namespace sinew::sim
