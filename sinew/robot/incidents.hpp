#pragma once
#include "sinew/base/error.hpp"
#include "sinew/base/time.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sinew::robot {

/// Something that the robot did or saw and nobody asked for: a limit, a fault, a reset, a time-out.
struct Incident {
    TimePoint at{};
    std::string joint; ///< empty: the whole robot
    Errc code{};
    std::string says; ///< one sentence
};

/// The latest incidents, the oldest first. More than `most` are not kept: the oldest go, and are counted.
class Incidents
{
public:
    static constexpr std::size_t most = 256;

    Incidents() { all_.reserve(most); }
    void add(Incident one)
    {
        if (all_.size() == most) {
            all_.erase(all_.begin());
            ++dropped_;
        }
        all_.push_back(std::move(one));
    }
    std::span<const Incident> all() const { return all_; }
    std::uint64_t dropped() const { return dropped_; }

private:
    std::vector<Incident> all_;
    std::uint64_t dropped_ = 0;
};

} // namespace sinew::robot
