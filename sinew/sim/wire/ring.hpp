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
        all_[(first_ + size_++) % all_.size()] = item;
        return true;
    }
    void pop()
    {
        first_ = (first_ + 1) % all_.size();
        --size_;
    }

private:
    std::vector<T> all_;
    std::size_t first_ = 0;
    std::size_t size_ = 0;
};

} // namespace sinew::sim
